// What multireach-publish sends, as the nodes that receive it see it.
#include <gtest/gtest.h>

#include "controller/node/controller_node.hpp"
#include "robot_bridge/sim/robot_sim_node.hpp"
#include "runtime/channels.hpp"
#include "tools/publish/messages.hpp"

namespace multireach {
namespace {

RobotConfig robot() {
  return RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2");
}

std::string fault_of(const auto& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Publish, ATargetByHandStartsTheController) {
  ControllerNode controller(robot());
  RobotSimNode arm(robot());
  Outbox out;
  while (out.empty()) arm.tick(out);
  controller.receive(channel::kRobotState, out.front().bytes, out);
  const auto bytes = encode(target_message("ball", {0.1, -0.12, 0.1}, {2, 0, 0, 0}, 5000000, 0, 42));
  ASSERT_TRUE(bytes);
  EXPECT_EQ(controller.receive(channel::kTarget, *bytes, out).utime, 5000000);
  EXPECT_EQ(controller.next_tick(), 5000000);
  EXPECT_EQ(controller.counters().refused, 0);
  const auto target = decode<target_t>(*bytes);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(target->velocity_m_s[i], 0);
    for (int j = 0; j < 3; ++j) EXPECT_EQ(target->covariance_m2[i][j], i == j ? 1e-6 : 0);
  }
}

TEST(Publish, ObstaclesOfEachShapeAreTakenByTheController) {
  ControllerNode controller(robot());
  Outbox out;
  obstacles_t message{};
  message.obstacles = {obstacle_message("sphere", {1, 0, 0}, {0.1}, {1, 0, 0, 0}),
                       obstacle_message("capsule", {1, 0, 0}, {0.1, 0.5}, {0, 2, 0, 0}),
                       obstacle_message("box", {1, 0, 0}, {0.1, 0.2, 0.3}, {0.7, 0.7, 0, 0})};
  message.num_obstacles = 3;
  controller.receive(channel::kObstacles, *encode(message), out);
  EXPECT_EQ(controller.counters().refused, 0);
  EXPECT_EQ(message.obstacles[1].orientation_wxyz[1], 1) << "normalised";
  EXPECT_EQ(message.obstacles[2].size_m[2], 0.3);
}

TEST(Publish, SaysWhatIsWrongWithAnObstacle) {
  const std::vector<double> turn{1, 0, 0, 0};
  EXPECT_EQ(fault_of([&] {
              (void)obstacle_message("cone", {0, 0, 0}, {1}, turn);
            }),
            "obstacle: 'cone' is no shape; expected sphere, capsule or box");
  EXPECT_EQ(fault_of([&] {
              (void)obstacle_message("capsule", {0, 0, 0}, {1}, turn);
            }),
            "obstacle: a capsule has two sizes, radius and length of the axis, in metres and positive");
  EXPECT_EQ(fault_of([&] {
              (void)obstacle_message("sphere", {0, 0, 0}, {-1}, turn);
            }),
            "obstacle: a sphere has one size, the radius, in metres and positive");
  EXPECT_EQ(fault_of([&] {
              (void)obstacle_message("sphere", {0, 0, 0}, {1}, {0, 0, 0, 0});
            }),
            "--orientation: the quaternion is zero");
}

TEST(Publish, ALinkThatTheRobotLacksIsRefusedByName) {
  EXPECT_EQ(fault_of([] { require_link(robot().urdf_path, "right_hand"); }), "");
  const std::string fault = fault_of([] { require_link(robot().urdf_path, "nose"); });
  EXPECT_NE(fault.find("has no link 'nose'; it has"), std::string::npos) << fault;
  EXPECT_NE(fault.find("right_hand"), std::string::npos) << fault;
  RobotSimNode simulated(robot());
  Outbox out;
  simulated.receive(channel::kPerturbation, *encode(perturbation_message("nose", {0, 0, 5}, 0.1, 0)), out);
  EXPECT_EQ(simulated.counters().refused, 1);
  EXPECT_NE(simulated.state().find("refused a push on 'nose'"), std::string::npos) << simulated.state();
}

TEST(Publish, APushMovesTheSimulatedRobot) {
  const auto push = encode(perturbation_message("right_hand", {0, 0, 5}, 0.1, 0));
  ASSERT_TRUE(push);
  RobotSimNode pushed(robot()), alone(robot());
  Outbox with, without;
  pushed.receive(channel::kPerturbation, *push, with);
  for (int ms = 0; ms < 50; ++ms) {
    pushed.tick(with);
    alone.tick(without);
  }
  EXPECT_EQ(pushed.counters().refused, 0);
  EXPECT_NE(with.back().bytes, without.back().bytes);
}

}  // namespace
}  // namespace multireach
