// The controller's node without LCM and without a clock: messages in, messages out.
#include <gtest/gtest.h>

#include <multireach/controller_state_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/obstacles_t.hpp>
#include <multireach/target_choice_t.hpp>

#include "controller/node/controller_node.hpp"
#include "kinematics/joint_frames.hpp"
#include "runtime/channels.hpp"
#include "runtime/joint_fields.hpp"
#include "tests/runtime/node_messages.hpp"

namespace multireach {
namespace {

using testing::kFront;
using testing::last_of;
using testing::robot;
using testing::robot_state;
using testing::target;

TEST(ControllerNode, WaitsForTheRobotThenForATarget) {
  ControllerNode node(robot());
  Outbox out;
  EXPECT_FALSE(node.receive(channel::kTarget, target(0, 1000, kFront), out).utime);
  EXPECT_FALSE(node.next_tick());
  EXPECT_EQ(node.state(), "waiting for the robot");
  node.receive(channel::kRobotState, robot_state(7), out);
  EXPECT_FALSE(node.next_tick());
  EXPECT_FALSE(node.receive(channel::kTarget, target(1, 1500, {NAN, 0, 0}), out).utime);
  EXPECT_FALSE(node.receive(channel::kTarget, target(1, 1600, kFront, target_t::STATUS_LOST), out).utime);
  EXPECT_FALSE(node.next_tick()) << "neither starts the grid";
  EXPECT_EQ(node.receive(channel::kTarget, target(1, 2000, kFront), out).utime, 2000);
  EXPECT_EQ(node.next_tick(), 2000);
  node.tick(out);
  const auto setpoint = last_of<joint_setpoint_t>(out, channel::kJointSetpoint);
  EXPECT_EQ(setpoint.utime, 2000);
  EXPECT_EQ(setpoint.tick, 0);
  EXPECT_EQ(setpoint.target_sequence, 1);
  EXPECT_EQ(setpoint.robot_state_sequence, 7);
  EXPECT_EQ(setpoint.joint_name, joint_names(robot().chain));
  const auto state = last_of<controller_state_t>(out, channel::kControllerState);
  EXPECT_EQ(state.mode, controller_state_t::MODE_REACHING);
  EXPECT_EQ(state.joint_position, setpoint.joint_position);
  EXPECT_LT(state.attractor_residual_m, 1e-6);
}

TEST(ControllerNode, CountsWhatIsMissingAndWhatItRefuses) {
  ControllerNode node(robot());
  Outbox out;
  node.receive(channel::kRobotState, robot_state(0), out);
  node.receive(channel::kTarget, target(0, 1000, kFront), out);
  node.receive(channel::kTarget, target(4, 2000, kFront), out);
  EXPECT_EQ(node.counters().dropped, 0) << "they may come yet";
  node.receive(channel::kTarget, target(5, 3000, {NAN, 0, 0}), out);
  node.receive(channel::kTarget, std::vector<uint8_t>{1, 2, 3}, out);
  EXPECT_EQ(node.counters().refused, 2);
  node.receive(channel::kTarget, target(6, INT64_MIN, kFront), out);
  node.receive(channel::kTarget, target(7, INT64_MAX, kFront), out);
  EXPECT_EQ(node.counters().refused, 4);
  EXPECT_EQ(node.next_tick(), 1000);
  for (int64_t k = 6; k < 70; ++k) node.receive(channel::kTarget, target(k, 1000 * k, kFront), out);
  EXPECT_EQ(node.counters().dropped, 3) << "64 later ones have come";
}

TEST(ControllerNode, AnotherTimeLineStartsTheGridAgain) {
  ControllerNode node(robot());
  Outbox out;
  node.receive(channel::kRobotState, robot_state(0), out);
  for (const int64_t start : {int64_t{5000000}, int64_t{900000000000}, int64_t{1000}}) {
    EXPECT_EQ(node.receive(channel::kTarget, target(0, start, kFront), out).utime, start);
    EXPECT_EQ(node.next_tick(), start);
    node.tick(out);
    EXPECT_EQ(last_of<joint_setpoint_t>(out, channel::kJointSetpoint).tick, 0);
  }
}

TEST(ControllerNode, ReachesForTheTargetOfItsName) {
  const Eigen::Vector3d elsewhere(0.12, -0.10, 0.05);
  Outbox out;
  ControllerNode first(robot());
  first.receive(channel::kRobotState, robot_state(0), out);
  first.receive(channel::kTarget, target(0, 1000, kFront), out);
  EXPECT_FALSE(first.receive(channel::kTarget, target(1, 1000, elsewhere, target_t::STATUS_TRACKED, "cup"), out).utime);
  first.tick(out);
  const auto state = last_of<controller_state_t>(out, channel::kControllerState);
  EXPECT_LT((Eigen::Map<const Eigen::Vector3d>(state.hand_target_m) - kFront).norm(), 1e-9);
  EXPECT_EQ(first.counters().dropped, 0);
}

std::vector<uint8_t> choice(int8_t kind, const std::string& name, int64_t run) {
  target_choice_t message{};
  message.kind = kind;
  message.name = name;
  message.run = run;
  message.chosen_by = "the page";
  return *encode(message);
}

TEST(ControllerNode, TakesAnAmbiguousTargetForALostOne) {
  ControllerNode ambiguous(robot()), lost(robot());
  Outbox first, second;
  for (ControllerNode* node : {&ambiguous, &lost}) {
    Outbox& out = node == &lost ? second : first;
    const int8_t status = node == &lost ? target_t::STATUS_LOST : target_t::STATUS_AMBIGUOUS;
    node->receive(channel::kRobotState, robot_state(0), out);
    node->receive(channel::kTarget, target(0, 1000, Eigen::Vector3d::Zero(), status), out);
    EXPECT_FALSE(node->next_tick()) << "it starts nothing";
    node->receive(channel::kTarget, target(1, 2000, kFront), out);
    node->receive(channel::kTarget, target(2, 3000, Eigen::Vector3d::Constant(NAN), status), out);
    EXPECT_EQ(node->counters().refused, 0) << "its position is not read";
  }
  ASSERT_EQ(first.size(), second.size());
  for (size_t k = 0; k < first.size(); ++k) EXPECT_EQ(first[k].bytes, second[k].bytes) << k;
}

TEST(ControllerNode, RefusesTargetsOfAnUnknownCameraPoseAndSaysWhy) {
  ControllerNode node(robot());
  Outbox out;
  node.receive(channel::kRobotState, robot_state(0), out);
  EXPECT_EQ(node.receive(channel::kTarget, target(0, 1000, kFront, target_t::STATUS_UNCALIBRATED), out).effect,
            Receipt::Effect::kNone);
  EXPECT_FALSE(node.next_tick());
  EXPECT_EQ(node.counters().refused, 1);
  EXPECT_NE(node.state().find("the camera pose is unknown"), std::string::npos) << node.state();
  EXPECT_EQ(node.receive(channel::kTarget, target(1, 2000, kFront), out).utime, 2000);
  EXPECT_EQ(node.state().find("the camera pose is unknown"), std::string::npos) << node.state();
  EXPECT_EQ(node.receive(channel::kTarget, target(2, 3000, kFront, 77), out).effect, Receipt::Effect::kNone);
  EXPECT_EQ(node.counters().refused, 2) << "no status that it knows";
}

TEST(ControllerNode, SaysWhenTheTargetIsInsideTheArmItself) {
  ControllerNode node(robot());
  Outbox out;
  node.receive(channel::kRobotState, robot_state(0), out);
  node.receive(channel::kTarget, target(0, 1000, kFront), out);
  node.tick(out);
  EXPECT_EQ(node.state().find("inside the arm"), std::string::npos) << node.state();
  const auto setpoint = last_of<joint_setpoint_t>(out, channel::kJointSetpoint);
  const Chain chain = robot().chain;
  // The longest link before the hand: the upper arm.
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  double longest = 0;
  std::string joint;
  visit_joints(chain, setpoint.joint_position, [&](int i, const auto&, const auto&, const Eigen::Isometry3d& X_WL) {
    const Eigen::Vector3d along = chain.fixed(i + 1).translation();
    if (i + 1 == chain.size() || !(along.norm() > longest)) return;
    longest = along.norm();
    middle = X_WL * Eigen::Vector3d(0.5 * along);
    joint = setpoint.joint_name[static_cast<size_t>(i)];
  });
  node.receive(channel::kTarget, target(1, 51000, middle), out);
  node.tick(out);
  EXPECT_NE(node.state().find("the target is inside the arm, in the link after joint '" + joint + "'"),
            std::string::npos)
      << node.state();
  node.receive(channel::kTarget, target(2, 101000, kFront), out);
  node.tick(out);
  EXPECT_EQ(node.state().find("inside the arm"), std::string::npos) << node.state();
}

TEST(ControllerNode, FollowsTheTargetThatIsChosenUntilTheChoiceEnds) {
  const Eigen::Vector3d elsewhere(0.12, -0.10, 0.05);
  ControllerNode node(robot());
  Outbox out;
  const auto goal = [&](int64_t k) {
    const int64_t utime = 2000 + 50000 * k;
    for (const auto& [name, p] : {std::pair("ball", kFront), std::pair("page", elsewhere)})
      node.receive(channel::kTarget, target(k, utime, p, target_t::STATUS_TRACKED, name), out);
    if (!node.next_tick()) return Eigen::Vector3d(0, 0, 0);
    node.tick(out);
    const auto state = last_of<controller_state_t>(out, channel::kControllerState);
    return Eigen::Vector3d(Eigen::Map<const Eigen::Vector3d>(state.hand_target_m));
  };
  node.receive(channel::kRobotState, robot_state(0), out);
  EXPECT_LT((goal(0) - kFront).norm(), 1e-9);
  EXPECT_EQ(node.receive(channel::kTargetChoice, choice(target_choice_t::NAMED, "page", 5), out).effect,
            Receipt::Effect::kConsumed);
  EXPECT_LT((goal(1) - elsewhere).norm(), 1e-9);
  EXPECT_NE(node.state().find("target 'page' chosen by the page"), std::string::npos) << node.state();
  EXPECT_EQ(node.receive(channel::kTargetChoice, choice(target_choice_t::NAMED, "ball", 6), out).effect,
            Receipt::Effect::kNone)
      << "another page, while the first is heard";
  EXPECT_EQ(node.receive(channel::kTargetChoice, choice(9, "", 5), out).effect, Receipt::Effect::kNone);
  EXPECT_LT((goal(2) - elsewhere).norm(), 1e-9);
  node.receive(channel::kTargetChoice, choice(target_choice_t::CONFIGURED, "", 5), out);
  EXPECT_LT((goal(3) - kFront).norm(), 1e-9);
  EXPECT_EQ(node.receive(channel::kTargetChoice, choice(target_choice_t::NONE, "", 6), out).effect,
            Receipt::Effect::kConsumed)
      << "the first has ended its choice";
  EXPECT_FALSE(node.next_tick()) << "no set-points";
  EXPECT_EQ(goal(4), Eigen::Vector3d(0, 0, 0));
  auto moved = *decode<robot_state_t>(robot_state(1));
  moved.joint_position[0] = -0.7;  // another program moved the arm
  node.receive(channel::kRobotState, *encode(moved), out);
  node.receive(channel::kTargetChoice, choice(target_choice_t::CONFIGURED, "", 6), out);
  EXPECT_LT((goal(5) - kFront).norm(), 1e-9);
  EXPECT_EQ(last_of<joint_setpoint_t>(out, channel::kJointSetpoint).tick, 0);
  EXPECT_EQ(last_of<joint_setpoint_t>(out, channel::kJointSetpoint).robot_state_sequence, 1);
}

TEST(ControllerNode, KeepsAwayFromObstaclesAndRefusesWhatIsNone) {
  ControllerNode node(robot());
  Outbox out;
  node.receive(channel::kRobotState, robot_state(7), out);
  const auto obstacle = [](int8_t shape, double size, double w) {
    obstacle_t sent{};
    sent.shape = shape;
    Eigen::Map<Eigen::Vector3d>(sent.position_m) = kFront;
    sent.orientation_wxyz[0] = w;
    Eigen::Map<Eigen::Vector3d>(sent.size_m).setConstant(size);
    return sent;
  };
  obstacles_t message{};
  message.sequence = 3;
  message.obstacles = {obstacle(obstacle_t::SPHERE, 0.02, 1), obstacle(obstacle_t::BOX, 0.01, 0),
                       obstacle(obstacle_t::CAPSULE, -1, 1), obstacle(9, 0.01, 1), obstacle(obstacle_t::BOX, NAN, 1)};
  message.num_obstacles = static_cast<int32_t>(message.obstacles.size());
  node.receive(channel::kObstacles, *encode(message), out);
  for (int64_t k = 0; k < 120; ++k) {
    node.receive(channel::kTarget, target(k, 2000 + 50000 * k, kFront), out);
    node.tick(out);
  }
  EXPECT_EQ(node.counters().refused, 4) << "no quaternion, a negative size, no known shape, no number";
  EXPECT_EQ(last_of<joint_setpoint_t>(out, channel::kJointSetpoint).obstacles_sequence, 3);
  const auto state = last_of<controller_state_t>(out, channel::kControllerState);
  const double distance = (Eigen::Map<const Eigen::Vector3d>(state.hand_position_m) - kFront).norm();
  EXPECT_NEAR(distance, 0.02 + 0.02 + 0.005, 2e-3)
      << "the target is inside the sphere: its surface, the link, the margin";
}

}  // namespace
}  // namespace multireach
