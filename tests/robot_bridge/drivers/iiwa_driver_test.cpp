// The iiwa's protocol: published fingerprints, the start guard, the rate, and what the emulator refuses.
#include <gtest/gtest.h>

#include <cmath>
#include <drake/lcmt_iiwa_command.hpp>
#include <drake/lcmt_iiwa_status.hpp>
#include <drake/lcmt_panda_command.hpp>
#include <drake/lcmt_panda_status.hpp>

#include "robot_bridge/drivers/emulators/iiwa_emulator.hpp"
#include "robot_bridge/drivers/iiwa_driver.hpp"
#include "tests/robot_bridge/drivers/driver_loop.hpp"

namespace multireach::testing {
namespace {

using drivers::Time;
using drivers::WireOutbox;

// The fingerprints of messages that Drake's drivers send and receive, as read in logs of others.
TEST(ThirdPartyMessages, HaveThePublishedFingerprints) {
  EXPECT_EQ(static_cast<uint64_t>(drake::lcmt_iiwa_command::getHash()), 0xddc7c7738c815334U);
  EXPECT_EQ(static_cast<uint64_t>(drake::lcmt_iiwa_status::getHash()), 0xf16fb804284abca3U);
  EXPECT_EQ(static_cast<uint64_t>(drake::lcmt_panda_command::getHash()), 0xe68df777004d59d0U);
  EXPECT_EQ(static_cast<uint64_t>(drake::lcmt_panda_status::getHash()), 0x19571cdf4d82fae6U);
}

TEST(ThirdPartyMessages, HaveThePublishedSizes) {
  drake::lcmt_iiwa_command command{};
  command.num_joints = 7;
  command.joint_position.resize(7);
  EXPECT_EQ(encode(command)->size(), 80U);
  command.num_torques = 7;
  command.joint_torque.resize(7);
  EXPECT_EQ(encode(command)->size(), 136U);
  drake::lcmt_panda_command panda{};
  panda.num_joint_position = 7;
  panda.joint_position.resize(7);
  EXPECT_EQ(encode(panda)->size(), 85U);
}

TEST(IiwaDriver, IsSilentUntilTheStartGuardIsOverAndThenSendsOneCommandInFiveMilliseconds) {
  DriverLoop loop(robot_named("iiwa14"));
  loop.keep_messages = true;
  loop.run(1299);
  EXPECT_TRUE(loop.robot_states.empty()) << "the first 200 statuses, one second, have no time";
  loop.run(5000);
  ASSERT_GT(loop.commands_sent.size(), 500U);
  EXPECT_GT(loop.commands_sent.front().first, 550);
  for (size_t k = 1; k < loop.commands_sent.size(); ++k)
    ASSERT_EQ(loop.commands_sent[k].first - loop.commands_sent[k - 1].first, 5) << k;
  EXPECT_EQ(loop.emulator().fault(), "");
}

class IiwaWire : public ::testing::Test {
 protected:
  std::vector<uint8_t> command(const JointVector& q) {
    drake::lcmt_iiwa_command message{};
    message.num_joints = static_cast<int32_t>(q.size());
    message.joint_position.assign(q.begin(), q.end());
    return *encode(message);
  }
  void wait(int64_t ms) {
    for (int64_t k = 0; k < ms; ++k) emulator.tick({us += 1000, us}, out);
  }
  void send(const JointVector& q) { emulator.receive(0, command(q), {us, us}, out); }

  const RobotConfig robot = robot_named("iiwa14");
  const Chain chain = load_chain(robot.urdf_path, "base", "iiwa_link_ee");
  const JointVector start = JointVector::Constant(7, 0.1);
  drivers::IiwaEmulator emulator{chain, start};
  WireOutbox out;
  int64_t us = 0;
};

TEST_F(IiwaWire, ACommandBeforeTheFirstStatusEndsTheDriver) {
  wait(150);
  send(start);
  wait(1000);
  EXPECT_TRUE(out.empty());
  EXPECT_EQ(emulator.fault(), "a command before the first status");
  emulator.restart();
  wait(1000);
  EXPECT_FALSE(out.empty());
}

TEST_F(IiwaWire, ACommandWithinTheGuardEndsTheDriver) {
  wait(400);
  ASSERT_FALSE(out.empty());
  send(start);
  EXPECT_EQ(emulator.fault(), "a command within 0.25 s of the first status");
}

TEST_F(IiwaWire, AStepFasterThanAJointMayMoveEndsTheSession) {
  wait(1000);
  JointVector q = start;
  const double largest = chain.velocity()[2] * 5e-3;
  q[2] += 0.99 * largest;
  send(q);
  wait(5);
  EXPECT_EQ(emulator.fault(), "");
  q[2] += 1.01 * largest;
  send(q);
  wait(5);
  EXPECT_EQ(emulator.fault(), "a commanded step is faster than a joint's largest speed");
}

TEST_F(IiwaWire, TheLastPositionIsHeldForEverAndLimitsAreClampedSilently) {
  wait(1000);
  JointVector q = start;
  for (int k = 0; k < 4000; ++k) {
    q[0] += 0.9 * chain.velocity()[0] * 1e-3;
    if (k % 5 == 0) send(q);
    wait(1);
  }
  wait(60000);
  EXPECT_EQ(emulator.fault(), "");
  EXPECT_NEAR(emulator.position()[0], 169 * std::numbers::pi / 180, 1e-6);
}

TEST_F(IiwaWire, ACommandThatIsNotFiniteEndsTheDriver) {
  wait(1000);
  JointVector q = start;
  q[3] = std::nan("");
  send(q);
  wait(10);
  EXPECT_EQ(emulator.fault(), "a command that is not finite");
  EXPECT_TRUE(emulator.position().allFinite());
}

drake::lcmt_iiwa_status status_of(int joints, double position, int64_t utime) {
  drake::lcmt_iiwa_status status{};
  status.utime = utime;
  status.num_joints = joints;
  for (auto* field : {&status.joint_position_measured, &status.joint_velocity_estimated,
                      &status.joint_position_commanded, &status.joint_position_ipo, &status.joint_torque_measured,
                      &status.joint_torque_commanded, &status.joint_torque_external})
    field->resize(static_cast<size_t>(joints));
  status.joint_position_measured.assign(static_cast<size_t>(joints), position);
  return status;
}

TEST(IiwaDriver, KeepsFollowingTheFirstArmBesideOthers) {
  DriverLoop loop(robot_named("iiwa14"));
  loop.run(4000);
  ASSERT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.driver().state();
  const int64_t clock = 1700000000000000;
  const auto goes_on = [&](const std::string& why) {
    loop.run(500);
    EXPECT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.bridge_state.cause;
    EXPECT_NE(loop.driver().state().find("ready, following"), std::string::npos) << loop.driver().state();
    EXPECT_NE(loop.driver().state().find(why), std::string::npos) << loop.driver().state();
    EXPECT_GT(loop.driver().counters().refused, 0);
    EXPECT_EQ(loop.emulator().fault(), "");
  };
  loop.inject("IIWA_STATUS", *encode(status_of(14, 0, clock + loop.now_ms() * 1000)));
  goes_on("of another number of joints");
  for (int k = 0; k < 100; ++k) {
    loop.inject("IIWA_STATUS", *encode(status_of(7, -1.2, clock + loop.now_ms() * 1000)));
    loop.run(5);
  }
  goes_on("of another arm");
  for (const int64_t utime : {INT64_MIN, INT64_MAX, clock - 3, int64_t{0}}) {
    loop.inject("IIWA_STATUS", *encode(status_of(7, 0.3, utime)));
    loop.run(20);
  }
  goes_on("IIWA_STATUS");
}

TEST(IiwaDriver, AReorderedStatusIsIgnored) {
  DriverLoop loop(robot_named("iiwa14"));
  loop.run(4000);
  loop.keep_messages = true;
  loop.run(500);
  const auto before = loop.robot_states.back();
  auto old = status_of(7, 0, 1700000000000000 + (loop.now_ms() - 60) * 1000);
  for (size_t i = 0; i < 7; ++i) old.joint_position_measured[i] = before.joint_position[i] - 0.02;
  loop.inject("IIWA_STATUS", *encode(old));
  loop.run(1);
  for (size_t i = 0; i < 7; ++i)
    EXPECT_NEAR(loop.robot_states.back().joint_position[i], before.joint_position[i], 0.01);
  EXPECT_NE(loop.driver().state().find("older"), std::string::npos) << loop.driver().state();
}

TEST(IiwaDriver, AWrongNumberOfJointsIsNamed) {
  drivers::IiwaDriver driver(6);
  const auto status = status_of(7, 0, 0);
  WireOutbox out;
  driver.receive(0, *encode(status), {0, 0}, out);
  EXPECT_EQ(driver.status().text, "IIWA_STATUS has another number of joints than robot.yaml");
  EXPECT_FALSE(driver.take_reading());
}

}  // namespace
}  // namespace multireach::testing
