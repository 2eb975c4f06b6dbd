// Lockstep without LCM: steps and messages in any order, messages out.
#include "runtime/lockstep.hpp"

#include <gtest/gtest.h>

#include <multireach/joint_setpoint_t.hpp>
#include <multireach/robot_state_t.hpp>

#include "robot_bridge/node/bridge_node.hpp"
#include "runtime/channels.hpp"

namespace multireach {
namespace {

std::vector<uint8_t> robot_state() {
  robot_state_t state{};
  state.simulated = true;
  state.num_joints = 4;
  state.joint_name = {"right_SFE", "right_SAA", "right_SHR", "right_EB"};
  state.joint_position = {0.2, -0.3, -0.2, -0.9};
  state.joint_velocity = state.joint_effort = std::vector<double>(4, 0.0);
  return *encode(state);
}

std::vector<uint8_t> setpoint(int64_t sequence) {
  joint_setpoint_t message{};
  message.utime = 1000000 + 50000 * sequence;
  message.sequence = sequence;
  message.num_joints = 4;
  message.joint_name = {"right_SFE", "right_SAA", "right_SHR", "right_EB"};
  message.joint_position = {0.2 + 0.01 * static_cast<double>(sequence), -0.3, -0.2, -0.9};
  message.joint_velocity = std::vector<double>(4, 0.0);
  return *encode(message);
}

replay_step_t step(int64_t number, int64_t ticks,
                   const std::vector<std::tuple<int64_t, std::string_view, std::vector<uint8_t>>>& inputs = {}) {
  replay_step_t step{};
  step.replay = 1;
  step.step = number;
  step.node = "bridge";
  step.ticks = ticks;
  step.num_inputs = static_cast<int32_t>(inputs.size());
  for (const auto& [before_tick, channel, bytes] : inputs) {
    step.before_tick.push_back(before_tick);
    append_channel(std::string(channel), step.channel_name, step.channel);
    step.digest.push_back(digest_of(bytes));
  }
  step.num_channels = static_cast<int32_t>(step.channel_name.size());
  return step;
}

class LockstepTest : public ::testing::Test {
 protected:
  LockstepTest() {
    EXPECT_TRUE(lockstep_.begin(step(0, 0)));
    EXPECT_TRUE(lockstep_.begin(step(1, 0)));
    lockstep_.advance(out_);
    EXPECT_TRUE(lockstep_.done());
  }
  /// Starts the bridge and lets it tick `ticks` times, with a second set-point after 50.
  replay_step_t work(int64_t ticks) const {
    return step(2, ticks,
                {{0, channel::kRobotState, robot_state()},
                 {0, channel::kJointSetpoint, setpoint(0)},
                 {50, channel::kJointSetpoint, setpoint(1)}});
  }
  void receive_all() {
    lockstep_.receive(channel::kJointSetpoint, setpoint(1));
    lockstep_.receive(channel::kJointSetpoint, setpoint(0));
    lockstep_.receive(channel::kRobotState, robot_state());
  }
  std::string all() const {
    std::string text;
    for (const OutMessage& message : out_) {
      if (message.channel == channel::kNodeInputs) continue;  // says which replay it is
      text += message.channel;
      text.append(message.bytes.begin(), message.bytes.end());
    }
    return text;
  }

  Lockstep lockstep_{
      [] { return std::make_unique<BridgeNode>(RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml")); }};
  Outbox out_;
};

TEST_F(LockstepTest, TakesMessagesInTheOrderOfTheStep) {
  EXPECT_TRUE(lockstep_.begin(work(80)));
  receive_all();
  lockstep_.advance(out_);
  EXPECT_TRUE(lockstep_.done());
  EXPECT_EQ(out_.size(), 84U) << "80 commands, 2 states of the bridge, 2 lists of inputs";
  EXPECT_EQ(lockstep_.report().sent, 82);
  EXPECT_FALSE(lockstep_.begin(work(80))) << "once only";
  lockstep_.advance(out_);
  EXPECT_EQ(out_.size(), 84U);
}

TEST_F(LockstepTest, GivesTheSameWheneverTheMessagesCome) {
  receive_all();
  lockstep_.begin(work(80));
  lockstep_.advance(out_);
  const std::string early = all();
  const int64_t digest = lockstep_.report().digest;
  out_.clear();
  replay_step_t again = step(0, 0);
  again.replay = 2;
  EXPECT_TRUE(lockstep_.begin(again)) << "another replay begins afresh";
  again.step = 1;
  lockstep_.begin(again);
  again = work(80);
  again.replay = 2;
  lockstep_.begin(again);
  lockstep_.advance(out_);
  EXPECT_FALSE(lockstep_.done());
  EXPECT_EQ(lockstep_.report().missing.size(), 3U);
  lockstep_.receive(channel::kRobotState, robot_state());
  lockstep_.receive(channel::kRobotState, robot_state());
  lockstep_.advance(out_);
  lockstep_.receive(channel::kJointSetpoint, setpoint(0));
  lockstep_.receive(channel::kJointSetpoint, setpoint(7));
  lockstep_.advance(out_);
  EXPECT_EQ(lockstep_.report().missing, std::vector<int64_t>{digest_of(setpoint(1))});
  lockstep_.receive(channel::kJointSetpoint, setpoint(1));
  lockstep_.advance(out_);
  EXPECT_TRUE(lockstep_.done());
  EXPECT_TRUE(all() == early) << "the bytes";
  EXPECT_EQ(lockstep_.report().digest, digest);
}

TEST_F(LockstepTest, ForgetsWhatCameBeforeAllHadBegun) {
  Lockstep other{
      [] { return std::make_unique<BridgeNode>(RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml")); }};
  other.receive(channel::kRobotState, robot_state());
  other.begin(step(0, 0));
  other.begin(step(1, 0));
  other.begin(step(2, 0, {{0, channel::kRobotState, robot_state()}}));
  other.advance(out_);
  EXPECT_FALSE(other.done());
}

}  // namespace
}  // namespace multireach
