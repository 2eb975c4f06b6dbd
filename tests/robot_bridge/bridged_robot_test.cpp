// The robot that is commanded: whether it follows, is the same one as before, and may be commanded.
#include <gtest/gtest.h>

#include "robot_bridge/stream_check.hpp"
#include "tests/robot_bridge/bridging.hpp"

namespace multireach::robot_bridge {
namespace {

TEST_F(Bridging, ARobotThatDoesNotFollowIsAFaultThatIsLatched) {
  Bridge bridge = running(10);
  const JointVector blocked = bridge.tick().theta;
  StreamCheck check(bridge.limits());
  int64_t k = 11, utime = 0;
  for (int ms = 0; ms < 5000 && bridge.next_tick(); ++ms) {
    if (ms % 50 == 0) (void)give(bridge, ramp(k++));
    const Command command = bridge.tick();
    check.add(command.theta);
    EXPECT_TRUE(bridge.measured(at(blocked, utime = command.utime)));
  }
  EXPECT_EQ(bridge.state(), BridgeState::kFault);
  EXPECT_STREQ(bridge.cause(), "the robot does not follow its commands");
  EXPECT_TRUE(check.keeps());
  EXPECT_FALSE(bridge.next_tick()) << "no commands until a reset";
  EXPECT_EQ(give(bridge, ramp(k)), SetpointVerdict::kNotReady);
  EXPECT_TRUE(bridge.reset());
  EXPECT_EQ(bridge.state(), BridgeState::kIdle) << "the robot may have gone meanwhile";
  EXPECT_EQ(give(bridge, ramp(k)), SetpointVerdict::kNotReady);
  EXPECT_TRUE(bridge.measured(at(blocked, utime)));
  EXPECT_EQ(bridge.state(), BridgeState::kArmed);
  Setpoint here = ramp(k);
  here.theta = blocked;
  EXPECT_EQ(give(bridge, here), SetpointVerdict::kAccepted);
  EXPECT_EQ(bridge.tick().theta, blocked) << "it starts from where the robot is";
}

TEST_F(Bridging, ARobotThatIsSilentStopsTheMotionThenIsAFault) {
  Bridge bridge = running(20);
  bool stopped = false;
  int64_t k = 21;
  for (int ms = 0; ms < 900; ++ms) {
    if (ms % 50 == 0) (void)give(bridge, ramp(k++));
    bridge.tick();
    stopped |= bridge.state() == BridgeState::kStopping;
  }
  EXPECT_TRUE(stopped);
  EXPECT_NE(bridge.state(), BridgeState::kFault);
  for (int ms = 0; ms < 200 && bridge.next_tick(); ++ms) bridge.tick();
  EXPECT_EQ(bridge.state(), BridgeState::kFault);
  EXPECT_FALSE(bridge.reset()) << "it is still silent";
}

TEST_F(Bridging, ARestartedRobotAndAJumpAreFaults) {
  Bridge restarted = running(20);
  for (int ms = 0; ms < 150; ++ms) restarted.tick();
  EXPECT_TRUE(heard_for_long(restarted, at(start_, 0, 78)));
  restarted.tick();
  EXPECT_STREQ(restarted.cause(), "the robot was restarted");
  EXPECT_EQ(restarted.robot_run(), kRobot) << "the new robot must not obey the old motion";
  Bridge jumped = running(20);
  const Command command = jumped.tick();
  EXPECT_TRUE(jumped.measured(at(command.theta + JointVector::Constant(4, 0.2), command.utime)));
  jumped.tick();
  EXPECT_STREQ(jumped.cause(), "the robot's measured position jumped");
}

TEST_F(Bridging, ARealRobotIsCommandedOnlyOnceEnabledAndAgainAfterItsRestart) {
  Bridge bridge(chain_, {});
  Measurement measurement = at(start_);
  measurement.real = true;
  bridge.enable();  // before the robot is known: not for this one
  EXPECT_TRUE(bridge.measured(measurement));
  EXPECT_EQ(bridge.state(), BridgeState::kIdle);
  EXPECT_EQ(give(bridge, ramp(0)), SetpointVerdict::kNotReady);
  bridge.enable();
  EXPECT_EQ(bridge.state(), BridgeState::kIdle) << "until its next state";
  EXPECT_TRUE(bridge.measured(measurement));
  EXPECT_EQ(bridge.state(), BridgeState::kArmed);
  EXPECT_EQ(give(bridge, ramp(0)), SetpointVerdict::kAccepted);
  for (int ms = 0; ms < 150; ++ms) bridge.tick();
  measurement.run = kRobot + 1;
  EXPECT_TRUE(heard_for_long(bridge, measurement));
  while (bridge.next_tick()) bridge.tick();
  EXPECT_EQ(bridge.state(), BridgeState::kFault);
  EXPECT_TRUE(bridge.measured(measurement));
  EXPECT_TRUE(bridge.reset());
  EXPECT_EQ(bridge.state(), BridgeState::kIdle) << "the restarted robot was not enabled";
}

TEST_F(Bridging, ARealRobotOfRunZeroAndOneThatPassedForSimulatedWaitToBeEnabled) {
  Bridge bridge(chain_, {});
  Measurement measurement = at(start_, 0, 0);
  measurement.real = true;
  EXPECT_TRUE(bridge.measured(measurement));
  EXPECT_EQ(bridge.state(), BridgeState::kIdle);
  Bridge other(chain_, {});
  EXPECT_TRUE(other.measured(at(start_)));
  EXPECT_EQ(other.state(), BridgeState::kArmed);
  measurement.run = kRobot;
  EXPECT_TRUE(other.measured(measurement));
  EXPECT_EQ(other.state(), BridgeState::kIdle);
}

TEST_F(Bridging, SilenceEndsALongSegmentAndAGoalBeyondTheLimitsIsInvalid) {
  Bridge bridge = running(10);
  for (int ms = 0; ms < 1000; ++ms) obeyed_tick(bridge);
  ASSERT_EQ(bridge.state(), BridgeState::kArmed);
  Setpoint far = ramp(40);
  far.velocity.setZero();
  far.theta[0] = chain_.upper()[0] + 5;
  EXPECT_EQ(give(bridge, far), SetpointVerdict::kInvalid);
  far.theta[0] = chain_.lower()[0];
  const double begin = bridge.tick().theta[0], distance = std::abs(far.theta[0] - begin);
  ASSERT_GT(distance, 1) << "longer than what is left of the time";
  for (int ms = 0; ms < 500; ++ms) {
    ASSERT_EQ(give(bridge, far), SetpointVerdict::kFarFromRobot) << "which asks the controller to start again";
    obeyed_tick(bridge);
  }
  far.utime = *bridge.next_tick();
  ASSERT_EQ(give(bridge, far), SetpointVerdict::kAccepted) << "the same controller resumes";
  EXPECT_EQ(bridge.setpoint_rate(), 0) << "the controller waits";
  double end = begin;
  for (int ms = 0; ms < 700; ++ms) end = obeyed_tick(bridge).theta[0];
  EXPECT_EQ(bridge.state(), BridgeState::kArmed) << "at rest after the time-out of 500 ms and a ramp of 0.2 s";
  EXPECT_LT(std::abs(end - begin), distance / 2);
}

TEST_F(Bridging, AControllerThatStaysFarIsApproachedSlowlyAndWaitsUntilTheRobotIsNear) {
  Bridge bridge = running(10);
  for (int ms = 0; ms < 1000; ++ms) obeyed_tick(bridge);
  ASSERT_EQ(bridge.state(), BridgeState::kArmed);
  Setpoint far = ramp(40);
  far.velocity.setZero();
  far.theta[0] += far.theta[0] > 0 ? -0.4 : 0.4;
  Setpoint other = far;
  other.run = far.run + 1;
  for (int k = 0; k < 20; ++k) ASSERT_EQ(give(bridge, other), SetpointVerdict::kFarFromRobot);
  for (int k = 0; k < 20; ++k)
    ASSERT_EQ(give(bridge, far), SetpointVerdict::kFarFromRobot) << "it had no time to answer";
  for (int ms = 0; ms < 500; ++ms) obeyed_tick(bridge);
  ASSERT_EQ(give(bridge, other), SetpointVerdict::kFarFromRobot) << "only the sender that was followed";
  far.utime = *bridge.next_tick();
  ASSERT_EQ(give(bridge, far), SetpointVerdict::kAccepted);
  ASSERT_EQ(bridge.state(), BridgeState::kRunning);
  StreamCheck check(bridge.limits());
  int waited_ms = 0;
  for (; waited_ms < 3000 && (waited_ms < 50 || bridge.setpoint_rate() == 0); ++waited_ms) {
    if (waited_ms % 50 == 0) {
      far.utime += kPeriod;
      ++far.sequence;
      EXPECT_EQ(give(bridge, far), SetpointVerdict::kAccepted);
    }
    check.add(obeyed_tick(bridge).theta);
  }
  EXPECT_GT(waited_ms, 100) << "0.3 rad at 20 % of 6 rad/s";
  EXPECT_LT(waited_ms, 1000);
  EXPECT_EQ(bridge.setpoint_rate(), 1);
  EXPECT_TRUE(check.keeps()) << check.velocity() << " " << check.acceleration() << " " << check.jerk();
}

TEST_F(Bridging, ARealRobotIsNotCommandedInTheLinearShape) {
  Bridge bridge(chain_, {.shape = BridgeOptions::Shape::kLinear});
  Measurement measurement = at(start_);
  measurement.real = true;
  EXPECT_TRUE(bridge.measured(measurement));
  bridge.enable();
  EXPECT_EQ(give(bridge, ramp(0)), SetpointVerdict::kNotReady);
}

TEST_F(Bridging, ARobotThatReportsAFaultIsNotCommandedUntilTheFaultIsOverAndReset) {
  Bridge bridge = running(10);
  const JointVector stopped = bridge.tick().theta;
  Measurement measurement = at(stopped, *bridge.next_tick());
  measurement.faulted = true;
  EXPECT_TRUE(bridge.measured(measurement));
  while (bridge.next_tick()) bridge.tick();
  EXPECT_EQ(bridge.state(), BridgeState::kFault);
  EXPECT_STREQ(bridge.cause(), "the robot reports a fault");
  EXPECT_TRUE(bridge.measured(measurement));
  EXPECT_TRUE(bridge.reset());
  EXPECT_EQ(bridge.state(), BridgeState::kIdle) << "its fault is not over";
  measurement.faulted = false;
  EXPECT_TRUE(bridge.measured(measurement));
  EXPECT_EQ(bridge.state(), BridgeState::kArmed);
}

TEST_F(Bridging, DisablingDeceleratesThenEndsTheStream) {
  Bridge bridge = running(20);
  StreamCheck check(bridge.limits());
  bridge.disable();
  EXPECT_EQ(bridge.state(), BridgeState::kStopping);
  while (bridge.next_tick()) check.add(obeyed_tick(bridge).theta);
  EXPECT_TRUE(check.keeps());
  EXPECT_EQ(bridge.state(), BridgeState::kIdle);
  EXPECT_EQ(give(bridge, ramp(22)), SetpointVerdict::kNotReady);
  bridge.enable();
  EXPECT_TRUE(bridge.measured(at(start_, 5000000)));
  EXPECT_EQ(bridge.state(), BridgeState::kArmed);
}

}  // namespace
}  // namespace multireach::robot_bridge
