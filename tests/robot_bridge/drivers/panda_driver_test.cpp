// The Panda's protocol: modes, expiry, the robot's limits, and the stream of the bridge without the rate limiter's
// help.
#include <gtest/gtest.h>

#include <cmath>
#include <drake/lcmt_panda_command.hpp>
#include <drake/lcmt_panda_status.hpp>

#include "robot_bridge/drivers/emulators/panda_emulator.hpp"
#include "robot_bridge/drivers/panda_driver.hpp"
#include "tests/robot_bridge/drivers/driver_loop.hpp"

namespace multireach::testing {
namespace {

using drivers::WireOutbox;

class PandaWire : public ::testing::Test {
 protected:
  void wait(int64_t ms) {
    for (int64_t k = 0; k < ms; ++k) emulator.tick({us += 1000, us}, out);
  }
  drake::lcmt_panda_command command(const JointVector& q) const {
    drake::lcmt_panda_command message{};
    message.utime = us;
    message.num_joint_position = 7;
    message.joint_position.assign(q.begin(), q.end());
    message.control_mode_expected = drake::lcmt_panda_command::CONTROL_MODE_POSITION;
    return message;
  }
  void send(const drake::lcmt_panda_command& message) { emulator.receive(0, *encode(message), {us, us}, out); }

  const RobotConfig robot = robot_named("panda");
  const Chain chain = load_chain(robot.urdf_path, "panda_link0", "panda_hand");
  const JointVector start = (JointVector(7) << 0, -0.785, 0, -2.356, 0, 1.571, 0.785).finished();
  drivers::PandaEmulator emulator{chain, start, {.limit_rate = false}};
  WireOutbox out;
  int64_t us = 0;
};

TEST_F(PandaWire, AnotherModeOrOtherArraysEndTheDriver) {
  wait(1000);
  auto message = command(start);
  message.control_mode_expected = drake::lcmt_panda_command::CONTROL_MODE_VELOCITY;
  send(message);
  EXPECT_EQ(emulator.fault(), "a command of another control mode");
  emulator.restart();
  wait(1000);
  message = command(start);
  message.num_joint_velocity = 7;
  message.joint_velocity.resize(7);
  send(message);
  EXPECT_EQ(emulator.fault(), "a command with other arrays than joint positions");
}

TEST_F(PandaWire, AnExpiredCommandIsNotFollowed) {
  wait(1000);
  const JointVector q = start + 0.5 * JointVector::Unit(7, 0);
  for (const int64_t error : {-102000, 102000}) {
    auto message = command(q);
    message.utime += error;
    send(message);
    wait(1);
    EXPECT_NEAR(emulator.position()[0], 0, 1e-12) << error;
  }
  EXPECT_EQ(emulator.fault(), "");
}

TEST_F(PandaWire, ACommandThatIsNotFiniteEndsTheDriver) {
  wait(1000);
  send(command(start * std::nan("")));
  wait(2);
  EXPECT_EQ(emulator.fault(), "a command that is not finite");
  EXPECT_TRUE(emulator.position().allFinite());
}

TEST_F(PandaWire, TimesAtTheEndsOfTheirRangeAreExpired) {
  wait(1000);
  for (const int64_t utime : {INT64_MIN, INT64_MAX, int64_t{-1}}) {
    auto message = command(start + 0.5 * JointVector::Unit(7, 0));
    message.utime = utime;
    send(message);
    wait(1);
    EXPECT_NEAR(emulator.position()[0], 0, 1e-12) << utime;
  }
  EXPECT_EQ(emulator.fault(), "");
}

// drake-franka-driver judges the age of a command by its own wall clock: whatever the clocks of the two computers do,
// the motion goes on, and Franka's limits are kept.
TEST(PandaDriver, NoStepOfAWallClockEndsAMotion) {
  for (const char* arm : {"panda", "fr3"}) {
    DriverLoop loop(robot_named(arm));
    loop.run(4000);
    ASSERT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.driver().state();
    for (const int64_t step : {200000, -600000, -3000000, 86400000}) {
      SCOPED_TRACE(step);
      loop.driver_clock_error_us += step;
      loop.run(700);
      loop.robot_clock_error_us += step / 2;
      loop.run(700);
      EXPECT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.driver().state();
      EXPECT_EQ(loop.emulator().fault(), "");
      EXPECT_NE(loop.driver().state().find("ready, following"), std::string::npos) << loop.driver().state();
      EXPECT_LT(loop.commands.hardest, 1.02);
      const JointVector there = loop.emulator().position();
      double moved = 0;
      for (int ms = 0; ms < 600; ++ms) {
        loop.run(1);
        moved = std::max(moved, (loop.emulator().position() - there).cwiseAbs().maxCoeff());
      }
      EXPECT_GT(moved, 1e-3) << "the arm moves";
    }
  }
}

drake::lcmt_panda_status panda_status(int joints, double position, int64_t utime) {
  drake::lcmt_panda_status status{};
  status.utime = utime;
  status.num_joints = joints;
  for (auto* field : {&status.joint_position, &status.joint_position_desired, &status.joint_velocity,
                      &status.joint_velocity_desired, &status.joint_acceleration_desired, &status.joint_torque,
                      &status.joint_torque_desired, &status.joint_torque_external})
    field->assign(static_cast<size_t>(joints), position);
  status.joint_velocity.assign(static_cast<size_t>(joints), 0);
  status.robot_mode = drake::lcmt_panda_status::MOVE;
  return status;
}

TEST(PandaDriver, KeepsFollowingTheFirstArmBesideOthers) {
  DriverLoop loop(robot_named("panda"));
  loop.run(4000);
  ASSERT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.driver().state();
  const int64_t clock = 1700000000000000;
  const auto send = [&](int joints, double position, int64_t utime, int8_t mode = drake::lcmt_panda_status::MOVE) {
    auto status = panda_status(joints, position, utime);
    status.robot_mode = mode;
    loop.inject("PANDA_STATUS", *encode(status));
    loop.run(5);
  };
  send(6, 0, clock + loop.now_ms() * 1000);
  for (int k = 0; k < 100; ++k) send(7, 1.2, clock + loop.now_ms() * 1000, drake::lcmt_panda_status::REFLEX);
  for (const int64_t utime : {INT64_MIN, INT64_MAX, int64_t{0}, int64_t{-1}}) send(7, 0, utime);
  loop.run(500);
  EXPECT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.bridge_state.cause;
  EXPECT_EQ(loop.emulator().fault(), "");
  const std::string state = loop.driver().state();
  EXPECT_NE(state.find("ready, following"), std::string::npos) << state;
  EXPECT_NE(state.find("of another number of joints"), std::string::npos) << state;
  EXPECT_NE(state.find("of another arm"), std::string::npos) << state;
}

TEST_F(PandaWire, AStepIsADiscontinuity) {
  wait(1000);
  send(command(start + 1e-3 * JointVector::Unit(7, 1)));  // filtered: 0.16 mrad in 1 ms, 160 rad/s^2
  wait(1);
  EXPECT_EQ(emulator.fault(), "joint_motion_generator_velocity_discontinuity");
}

TEST_F(PandaWire, AJerkIsADiscontinuity) {
  wait(1000);
  // Filtered: 5.6 rad/s^2 within 1 ms, 5600 rad/s^3 of 3750.
  send(command(start + 3.5e-5 * JointVector::Unit(7, 1)));
  wait(1);
  EXPECT_EQ(emulator.fault(), "joint_motion_generator_acceleration_discontinuity");
}

TEST_F(PandaWire, TheRateLimiterKeepsTheRobotMovingAfterAStep) {
  drivers::PandaEmulator limited{chain, start};
  for (int k = 0; k < 4000; ++k) {
    us += 1000;
    limited.tick({us, us}, out);
    const JointVector q = start + (k > 1000 ? 0.01 : 0) * JointVector::Unit(7, 1);
    limited.receive(0, *encode(command(q)), {us, us}, out);
  }
  EXPECT_EQ(limited.fault(), "");
  EXPECT_NEAR(limited.position()[1], start[1] + 0.01, 1e-3);
}

// Franka publishes, besides its curves of speed over position, one speed for each joint that holds within narrower
// position limits: that point lies on the curve.
TEST(Research3, TheCurvesOfVelocityMeetTheConstantLimits) {
  const RobotConfig robot = robot_named("fr3");
  const JointVector constant = (JointVector(7) << 2, 1, 1.5, 1.25, 3, 1.5, 3).finished();
  const JointVector up = drivers::research3_velocity(robot.chain.upper(), true);
  const JointVector down = drivers::research3_velocity(robot.chain.lower(), false);
  for (int i = 0; i < 7; ++i) {
    EXPECT_NEAR(up[i], constant[i], 1e-3) << robot.chain.joint(i).name;
    EXPECT_NEAR(down[i], constant[i], 1e-3) << robot.chain.joint(i).name;
    EXPECT_LE(robot.chain.velocity()[i], constant[i] / 3 + 1e-3) << robot.chain.joint(i).name;
  }
}

// 2 rad/s towards the limit of the first joint at 2.74 rad: the Panda does that, the Research 3 stops at 2.31 rad.
TEST(Research3, IsSlowerTowardsItsPositionLimits) {
  const RobotConfig robot = robot_named("fr3");
  std::vector<Joint> joints = robot.chain.joints();
  std::vector<Eigen::Isometry3d> fixed;
  for (int i = 0; i <= 7; ++i) fixed.push_back(robot.chain.fixed(i));
  joints[0].upper = 2.7437;
  for (Joint& joint : joints) joint.velocity = 2.62;
  const Chain chain(joints, fixed, robot.chain.base(), robot.chain.tip());
  JointVector start = 0.5 * (chain.lower() + chain.upper());
  start[0] = 1.5;
  for (const auto model : {drivers::FrankaModel::kPanda, drivers::FrankaModel::kResearch3}) {
    drivers::PandaEmulator emulator(chain, start, {.model = model, .limit_rate = false});
    WireOutbox out;
    JointVector q = start;
    for (int64_t ms = 1; ms < 1750; ++ms) {
      emulator.tick({ms * 1000, ms * 1000}, out);
      q[0] += 1e-3 * std::clamp(5e-3 * static_cast<double>(ms - 1000), 0.0, 2.0);
      drake::lcmt_panda_command message{};
      message.utime = ms * 1000;
      message.num_joint_position = 7;
      message.joint_position.assign(q.begin(), q.end());
      message.control_mode_expected = drake::lcmt_panda_command::CONTROL_MODE_POSITION;
      emulator.receive(0, *encode(message), {ms * 1000, ms * 1000}, out);
    }
    if (model == drivers::FrankaModel::kPanda) {
      EXPECT_EQ(emulator.fault(), "");
    } else {
      EXPECT_EQ(emulator.fault(), "joint_motion_generator_velocity_limits_violation");
      EXPECT_NEAR(emulator.position()[0], 2.3093, 0.02);
    }
  }
}

class FrankaStream : public ::testing::TestWithParam<const char*> {};

// The stream of the bridge, each command once, through the filter alone: no limit of the robot is broken.
TEST_P(FrankaStream, NeedsNoRateLimiter) {
  const RobotConfig robot = robot_named(GetParam());
  DriverLoop loop(robot);
  loop.keep_messages = true;
  loop.run(30000);
  ASSERT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING);
  ASSERT_GT(loop.commands_sent.size(), 25000U);
  const Chain chain = load_chain(robot.urdf_path, robot.chain.base(), robot.chain.tip());
  JointVector start(7);
  for (int i = 0; i < 7; ++i) start[i] = robot.start.at(chain.joint(i).name);
  const auto model = drivers::driver_config_from(robot, "").franka_model;
  drivers::PandaEmulator strict{chain, start, {.model = model, .limit_rate = false}};
  WireOutbox out;
  int64_t ms = loop.commands_sent.front().first - 1000;
  const auto wall = [&] {
    return decode<drake::lcmt_panda_command>(loop.commands_sent.front().second)->utime +
           (ms - loop.commands_sent.front().first) * 1000;
  };
  for (const auto& [at, bytes] : loop.commands_sent) {
    for (; ms < at; ++ms) strict.tick({ms * 1000, wall()}, out);
    strict.receive(0, bytes, {ms * 1000, wall()}, out);
  }
  EXPECT_EQ(strict.fault(), "");
  EXPECT_GT((strict.position() - start).norm(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Both, FrankaStream, ::testing::Values("panda", "fr3"),
                         [](const auto& each) { return std::string(each.param); });

TEST(PandaDriver, NamesTheRobotsMode) {
  drivers::PandaDriver driver(7);
  WireOutbox out;
  const auto text_of = [&](int8_t mode) {
    drake::lcmt_panda_status status{};
    status.num_joints = 7;
    status.robot_mode = mode;
    for (auto* field : {&status.joint_position, &status.joint_position_desired, &status.joint_velocity,
                        &status.joint_velocity_desired, &status.joint_acceleration_desired, &status.joint_torque,
                        &status.joint_torque_desired, &status.joint_torque_external})
      field->resize(7);
    for (int64_t us = 1000; us < 300000; us += 1000) {
      status.utime = us;
      driver.receive(0, *encode(status), {us, us}, out);
      driver.tick({us, us}, out);
    }
    return driver.status().text;
  };
  EXPECT_EQ(text_of(drake::lcmt_panda_status::MOVE), "ready");
  EXPECT_NE(text_of(drake::lcmt_panda_status::REFLEX).find("reflex"), std::string::npos);
  EXPECT_NE(text_of(drake::lcmt_panda_status::USER_STOPPED).find("user stop"), std::string::npos);
}

}  // namespace
}  // namespace multireach::testing
