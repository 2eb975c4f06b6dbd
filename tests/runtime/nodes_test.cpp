// The nodes without LCM and without a clock: messages in, messages out.
#include <gtest/gtest.h>

#include <multireach/bridge_request_t.hpp>
#include <multireach/bridge_state_t.hpp>
#include <multireach/controller_state_t.hpp>
#include <multireach/joint_command_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/robot_state_t.hpp>

#include "camera/node/camera_node.hpp"
#include "camera/node/render_source.hpp"
#include "controller/node/controller_node.hpp"
#include "numeric/random.hpp"
#include "robot_bridge/node/bridge_node.hpp"
#include "robot_bridge/sim/robot_sim_node.hpp"
#include "runtime/channels.hpp"
#include "runtime/input_journal.hpp"
#include "runtime/joint_fields.hpp"
#include "tests/allocation_count.hpp"
#include "tests/runtime/node_messages.hpp"
#include "tests/temporary_folder.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach {
namespace {

using testing::kFront;
using testing::last_of;
using testing::robot;
using testing::robot_state;
using testing::target;

// Another robot on the group: what the node does next depends on each of its messages, so each is recorded, and the
// record is published although nothing is commanded.
TEST(BridgeNode, RecordsTheStatesOfAnotherRobotUntilItIsFollowed) {
  BridgeNode node(robot());
  Outbox out;
  using Effect = Receipt::Effect;
  EXPECT_EQ(node.receive(channel::kRobotState, robot_state(0), out).effect, Effect::kReplaces);
  auto other = *decode<robot_state_t>(robot_state(0));
  other.run = 99;
  for (int k = 0; k < 9; ++k) {
    other.sequence = k;
    EXPECT_EQ(node.receive(channel::kRobotState, *encode(other), out).effect, Effect::kConsumed) << k;
  }
  EXPECT_NE(node.state().find("robot states refused: 9 of another robot"), std::string::npos) << node.state();
  EXPECT_TRUE(out.empty());
  EXPECT_EQ(node.receive(channel::kRobotState, robot_state(1), out).effect, Effect::kReplaces);
  for (int k = 0; k < 50; ++k) {
    (void)node.receive(channel::kRobotState, *encode(other), out);
    (void)node.receive(channel::kRobotState, robot_state(2 + k), out);
  }
  EXPECT_EQ(last_of<bridge_state_t>(out, channel::kBridgeState).robot_run, decode<robot_state_t>(robot_state(0))->run);
  for (int k = 0; k < 10; ++k)
    EXPECT_EQ(node.receive(channel::kRobotState, *encode(other), out).effect, Effect::kConsumed) << k;
  EXPECT_EQ(node.receive(channel::kRobotState, *encode(other), out).effect, Effect::kReplaces);
}

// At its priority, a bridge that waits for memory waits for everyone who has some.
TEST(BridgeNode, OnceItRunsATickAllocatesNothing) {
  BridgeNode node(robot());
  InputJournal journal("bridge", 1, 1, 1, 72);
  Outbox out;
  std::vector<uint8_t> inputs;
  joint_setpoint_t setpoint{};
  setpoint.run = 5;
  setpoint.num_joints = 4;
  const auto state = *decode<robot_state_t>(robot_state(0));
  for (const size_t joint : {2u, 3u, 4u, 0u}) {
    setpoint.joint_name.push_back(state.joint_name[joint]);
    setpoint.joint_position.push_back(state.joint_position[joint]);
    setpoint.joint_velocity.push_back(0);
  }
  int64_t allocated = 0, sent = 0;
  const auto receive = [&](std::string_view channel, const std::vector<uint8_t>& bytes) {
    const int64_t before = testing::allocations().number;
    const Receipt receipt = node.receive(channel, bytes, out);
    allocated += testing::allocations().number - before;
    journal.record(receipt, channel, bytes);
  };
  for (int64_t ms = 0; ms < 2000; ++ms) {
    if (ms == 1000) allocated = 0;
    if (ms % 5 == 0) receive(channel::kRobotState, robot_state(ms / 5));
    if (ms % 50 == 0) {
      setpoint.utime = ms * 1000;
      setpoint.sequence = ms / 50;
      receive(channel::kJointSetpoint, *encode(setpoint));
    }
    if (!node.next_tick()) continue;
    const int64_t before = testing::allocations().number;
    node.tick(out);
    (void)journal.next_message(inputs);
    sent += static_cast<int64_t>(out.size());
    node.reuse(out);
    allocated += testing::allocations().number - before;
  }
  EXPECT_GE(sent, 2000);
  EXPECT_EQ(allocated, 0);
}

TEST(BridgeNode, ObeysOnlyRequestsThatNameIt) {
  BridgeNode node(robot());
  node.set_run(7);
  Outbox out;
  bridge_request_t request{};
  request.kind = bridge_request_t::SPEED;
  request.speed = 0.3;
  request.request = 1;
  request.run = 8;
  EXPECT_EQ(node.receive(channel::kBridgeRequest, *encode(request), out).effect, Receipt::Effect::kNone);
  EXPECT_TRUE(out.empty());
  EXPECT_EQ(node.counters().refused, 1);
  request.run = 7;
  EXPECT_EQ(node.receive(channel::kBridgeRequest, *encode(request), out).effect, Receipt::Effect::kConsumed);
  const auto state = last_of<bridge_state_t>(out, channel::kBridgeState);
  EXPECT_EQ(state.request, 1);
  EXPECT_EQ(state.run, 7);
  EXPECT_TRUE(state.request_accepted);
  EXPECT_EQ(state.speed, 0.3);
  request.speed = 2;
  request.request = 2;
  (void)node.receive(channel::kBridgeRequest, *encode(request), out);
  EXPECT_FALSE(last_of<bridge_state_t>(out, channel::kBridgeState).request_accepted);
}

TEST(BridgeNode, StopsWhenEveryBridgeIsAskedToAndSaysWhyItIsIdle) {
  BridgeNode node(robot());
  node.set_run(7);
  Outbox out;
  bridge_request_t request{};
  request.run = bridge_request_t::ALL;
  request.kind = bridge_request_t::ENABLE;
  EXPECT_EQ(node.receive(channel::kBridgeRequest, *encode(request), out).effect, Receipt::Effect::kNone);
  request.kind = bridge_request_t::DISABLE;
  EXPECT_EQ(node.receive(channel::kBridgeRequest, *encode(request), out).effect, Receipt::Effect::kConsumed);
  EXPECT_EQ(last_of<bridge_state_t>(out, channel::kBridgeState).cause, "disabled");
  request.run = 7;
  request.kind = bridge_request_t::ENABLE;
  (void)node.receive(channel::kBridgeRequest, *encode(request), out);
  EXPECT_EQ(last_of<bridge_state_t>(out, channel::kBridgeState).cause, "waiting for the robot");
}

TEST(WholeLoopWithoutLcm, AControllerWhoseRobotIsElsewhereStartsAgainFromThere) {
  ControllerNode controller(robot());
  controller.set_run(21);
  Outbox out;
  controller.receive(channel::kRobotState, robot_state(0), out);
  for (int64_t k = 0; k < 40; ++k) {
    controller.receive(channel::kTarget, target(k, 2000 + 50000 * k, kFront), out);
    controller.tick(out);
  }
  const auto reached = last_of<joint_setpoint_t>(out, channel::kJointSetpoint);
  // A bridge that starts now hears a robot that is still where it began.
  BridgeNode bridge(robot());
  bridge.set_run(22);
  const auto measured = robot_state(1);
  (void)bridge.receive(channel::kRobotState, measured, out);
  EXPECT_FALSE(bridge.receive(channel::kJointSetpoint, *encode(reached), out).utime);
  const auto refusal = out.back();
  EXPECT_EQ(decode<bridge_state_t>(refusal.bytes)->far_run, 21);
  (void)controller.receive(channel::kBridgeState, refusal.bytes, out);
  EXPECT_EQ(controller.receive(channel::kRobotState, measured, out).effect, Receipt::Effect::kConsumed);
  controller.receive(channel::kTarget, target(40, 2000 + 50000 * 40, kFront), out);
  controller.tick(out);
  const auto again = last_of<joint_setpoint_t>(out, channel::kJointSetpoint);
  EXPECT_EQ(bridge.receive(channel::kJointSetpoint, *encode(again), out).utime, again.utime) << "near the robot";

  ControllerNode other(robot());  // another one's refusal
  other.set_run(23);
  other.receive(channel::kRobotState, robot_state(0), out);
  other.receive(channel::kTarget, target(0, 2000, kFront), out);
  (void)other.receive(channel::kBridgeState, refusal.bytes, out);
  EXPECT_EQ(other.receive(channel::kRobotState, measured, out).effect, Receipt::Effect::kNone);
}

TEST(RobotSimNode, ObeysOnlyCommandsThatNameIt) {
  RobotSimNode node(robot());
  node.set_run(5);
  Outbox out;
  joint_command_t command{};
  command.run = 3;
  command.robot_run = 4;
  command.num_joints = 1;
  command.joint_name = {"right_EB"};
  command.joint_position = {-0.5};
  command.joint_velocity = {0};
  (void)node.receive(channel::kJointCommand, *encode(command), out);
  EXPECT_EQ(node.counters().refused, 1);
  command.robot_run = 5;
  (void)node.receive(channel::kJointCommand, *encode(command), out);
  EXPECT_EQ(node.counters().refused, 1);
  command.run = 9;
  (void)node.receive(channel::kJointCommand, *encode(command), out);
  EXPECT_EQ(node.counters().refused, 2) << "a second bridge";
}

TEST(BridgeNode, RefusesJointsThatAreNotTheRobots) {
  BridgeNode node(robot());
  Outbox out;
  node.receive(channel::kRobotState, robot_state(0), out);
  joint_setpoint_t setpoint{};
  setpoint.num_joints = 1;
  setpoint.joint_name = {"nose"};
  setpoint.joint_position = setpoint.joint_velocity = {1};
  EXPECT_FALSE(node.receive(channel::kJointSetpoint, *encode(setpoint), out).utime);
  EXPECT_FALSE(node.next_tick());
  EXPECT_EQ(node.counters().refused, 1);
}

// Enough of them end the motion (Bridge), so a replay needs to know them.
TEST(BridgeNode, RecordsSetpointsThatAreRefusedForTheirTime) {
  ControllerNode controller(robot());
  BridgeNode bridge(robot());
  controller.set_run(21);
  Outbox out;
  controller.receive(channel::kRobotState, robot_state(0), out);
  bridge.receive(channel::kRobotState, robot_state(0), out);
  controller.receive(channel::kTarget, target(0, 2000, kFront), out);
  controller.tick(out);
  auto setpoint = last_of<joint_setpoint_t>(out, channel::kJointSetpoint);
  EXPECT_TRUE(bridge.receive(channel::kJointSetpoint, *encode(setpoint), out).restarts_ticks);
  setpoint.sequence += 1;
  setpoint.utime += 500000;
  const Receipt receipt = bridge.receive(channel::kJointSetpoint, *encode(setpoint), out);
  EXPECT_EQ(receipt.effect, Receipt::Effect::kConsumed);
  EXPECT_FALSE(receipt.utime) << "a wrong time must not move the clock";
  EXPECT_EQ(bridge.counters().refused, 1);
}

TEST(VisionNode, AnUnreadableImageGivesNoMatch) {
  VisionNode vision(VisionConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml"));
  CameraNode camera(std::make_unique<RenderSource>(MULTIREACH_SOURCE_DIR "/logs/reach.yaml"));
  Outbox out;
  const auto next = [&] {
    Outbox images;
    camera.tick(images);
    return last_of<images_t>(images, channel::kStereoImages);
  };
  const images_t first = next();
  EXPECT_EQ(vision.receive(channel::kStereoImages, *encode(first), out).utime, first.utime);
  const auto seen = last_of<target_t>(out, channel::kTarget);
  EXPECT_EQ(seen.status, target_t::STATUS_TRACKED);
  EXPECT_EQ(seen.pair_sequence, 0);
  EXPECT_EQ(seen.left_frame_utime, first.images[0].utime);

  images_t last;
  for (int k = 0; k < 10; ++k) {
    last = next();
    vision.receive(channel::kStereoImages, *encode(last), out);
  }
  const auto expect_unseen = [&](const images_t& images, const std::string& reason) {
    vision.receive(channel::kStereoImages, *encode(images), out);
    const auto target = last_of<target_t>(out, channel::kTarget);
    EXPECT_EQ(target.status, target_t::STATUS_COASTING);
    EXPECT_EQ(target.reason, reason);
    EXPECT_EQ(target.last_seen_utime, last.utime);
  };
  images_t bad = next();
  bad.images[1].data.resize(bad.images[1].data.size() / 4);
  bad.images[1].size = static_cast<int32_t>(bad.images[1].data.size());
  expect_unseen(bad, "an image cannot be decoded");
  bad = next();
  bad.image_types = {images_t::LEFT, 7};
  expect_unseen(bad, "there is no right image");
  EXPECT_EQ(last_of<target_t>(out, channel::kTarget).right_frame_utime, -1);
  bad = next();
  bad.images.erase(bad.images.begin());
  bad.image_types.erase(bad.image_types.begin());
  bad.n_images = 1;
  expect_unseen(bad, "there is no left image");
  bad = next();
  bad.images[0].width = 99999;
  expect_unseen(bad, "the size of an image differs from the calibration");
  expect_unseen(first, "the pair is not newer than the last one");
  vision.receive(channel::kStereoImages, *encode(next()), out);
  EXPECT_EQ(last_of<target_t>(out, channel::kTarget).status, target_t::STATUS_TRACKED) << "and goes on";
  EXPECT_EQ(last_of<target_t>(out, channel::kTarget).sequence, 16) << "one target for every message";
}

TEST(VisionNode, WithoutTheCameraPoseTargetsAreUncalibratedAndInTheCamerasFrame) {
  const VisionConfig known = VisionConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml");
  VisionConfig unknown = known;
  unknown.calibrated = false;
  unknown.rig.X_WL.setIdentity();
  for (VisionConfig::Target& target : unknown.targets) target.options.rig = unknown.rig;
  VisionNode with(known), without(unknown);
  const testing::TemporaryFolder folder;
  const std::string scene = folder / "scene.yaml";
  write_text_file(scene, "vision: " MULTIREACH_SOURCE_DIR
                         "/robots/hoap2/vision.yaml\nend_s: 1\npath:\n"
                         "  - {at_s: 0, position_m: [0.1, -0.12, 0.1]}\n  - {at_s: 0.5, hidden_for_s: 1}\n");
  CameraNode camera(std::make_unique<RenderSource>(scene));
  Outbox images, out, out_without;
  int coasted = 0;
  for (int k = 0; k < 20; ++k) {
    camera.tick(images);
    const std::vector<uint8_t>& bytes = images.back().bytes;
    with.receive(channel::kStereoImages, bytes, out);
    without.receive(channel::kStereoImages, bytes, out_without);
    const auto in_W = last_of<target_t>(out, channel::kTarget), in_L = last_of<target_t>(out_without, channel::kTarget);
    if (in_W.status != target_t::STATUS_TRACKED) {
      EXPECT_EQ(in_L.status, target_t::STATUS_LOST) << "a position that is only expected is of no use";
      coasted += in_W.status == target_t::STATUS_COASTING;
      continue;
    }
    ASSERT_EQ(in_L.status, target_t::STATUS_UNCALIBRATED) << k;
    const Eigen::Vector3d p_LT = Eigen::Map<const Eigen::Vector3d>(in_L.position_m);
    EXPECT_LT((known.rig.X_WL * p_LT - Eigen::Map<const Eigen::Vector3d>(in_W.position_m)).norm(), 1e-9);
  }
  EXPECT_GT(coasted, 0);
  EXPECT_NE(without.state().find("ball"), std::string::npos);
}

/// The whole loop in one thread, in the time of the messages: every node ticks when its next tick is due.
class WholeLoop {
 public:
  std::vector<uint8_t> run(int64_t duration_us) {
    const int64_t origin = *camera_.next_tick();
    for (int64_t now = origin; now < origin + duration_us; now += 1000) {
      while (robot_.next_tick() && *robot_.next_tick() <= now - origin) step(robot_);
      while (camera_.next_tick() && *camera_.next_tick() <= now) step(camera_);
      while (controller_.next_tick() && *controller_.next_tick() <= now) step(controller_);
      while (bridge_.next_tick() && *bridge_.next_tick() <= now) step(bridge_);
    }
    return commands_;
  }
  const NodeCounters& counters(int node) const { return nodes_[static_cast<size_t>(node)]->counters(); }
  Eigen::Vector3d hand() const { return hand_; }
  Eigen::Vector3d truth() const { return truth_; }

 private:
  void step(Node& node) {
    Outbox out;
    node.tick(out);
    deliver(out);
  }
  void deliver(const Outbox& out) {
    for (const OutMessage& message : out) {
      if (message.channel == channel::kJointCommand)
        commands_.insert(commands_.end(), message.bytes.begin(), message.bytes.end());
      if (message.channel == channel::kTargetTruth)
        truth_ = Eigen::Map<const Eigen::Vector3d>(decode<target_t>(message.bytes)->position_m);
      if (message.channel == channel::kRobotState) {
        const auto state = *decode<robot_state_t>(message.bytes);
        hand_ = chain_.position(*from_fields(chain_, state.joint_name, state.joint_position));
      }
      for (Node* node : nodes_) {
        const auto inputs = node->inputs();
        if (std::ranges::find(inputs, message.channel) == inputs.end()) continue;
        Outbox answers;
        node->receive(message.channel, message.bytes, answers);
        deliver(answers);
      }
    }
  }

  Chain chain_ = robot().chain;
  CameraNode camera_{std::make_unique<RenderSource>(MULTIREACH_SOURCE_DIR "/logs/reach.yaml")};
  VisionNode vision_{VisionConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml")};
  ControllerNode controller_{robot()};
  BridgeNode bridge_{robot()};
  RobotSimNode robot_{robot()};
  std::vector<Node*> nodes_{&vision_, &controller_, &bridge_, &robot_};
  std::vector<uint8_t> commands_;
  Eigen::Vector3d hand_{0, 0, 0}, truth_{0, 0, 0};
};

TEST(WholeLoopWithoutLcm, ReachesTheBall) {
  WholeLoop loop;
  loop.run(2800000);
  EXPECT_LT((loop.hand() - loop.truth()).norm(), 5e-3);
  for (int node = 0; node < 4; ++node) {
    EXPECT_EQ(loop.counters(node).dropped, 0) << node;
    EXPECT_EQ(loop.counters(node).refused, 0) << node;
  }
}

TEST(WholeLoopWithoutLcm, TheSameBytesEveryTime) {
  const std::vector<uint8_t> first = WholeLoop().run(1500000), second = WholeLoop().run(1500000);
  EXPECT_GT(first.size(), 100000U);
  EXPECT_EQ(first, second);
}

}  // namespace
}  // namespace multireach
