// The stream of commands: set-points in, one command a tick out.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>

#include "robot_bridge/stream_check.hpp"
#include "tests/allocation_count.hpp"
#include "tests/robot_bridge/bridging.hpp"

namespace multireach::robot_bridge {
namespace {

TEST_F(Bridging, IsSilentUntilItKnowsTheRobotAndASetpoint) {
  Bridge bridge(chain_, {});
  EXPECT_EQ(bridge.state(), BridgeState::kIdle);
  EXPECT_EQ(give(bridge, ramp(0)), SetpointVerdict::kNotReady) << "where the robot is, is not known";
  EXPECT_FALSE(bridge.next_tick());
  EXPECT_TRUE(bridge.measured(at(start_)));
  EXPECT_EQ(bridge.state(), BridgeState::kArmed);
  EXPECT_FALSE(bridge.next_tick());
  EXPECT_EQ(give(bridge, ramp(0)), SetpointVerdict::kAccepted);
  EXPECT_EQ(bridge.state(), BridgeState::kRunning);
  EXPECT_EQ(*bridge.next_tick(), 0);
}

TEST_F(Bridging, ReachesEachSetpointOnePeriodAndTheDelayAfterItsTime) {
  Bridge bridge(chain_, {});
  EXPECT_TRUE(bridge.measured(at(start_)));
  for (int64_t k = 0; k < 30; ++k) {
    EXPECT_EQ(give(bridge, ramp(k)), SetpointVerdict::kAccepted);
    for (int64_t ms = 0; ms < 50; ++ms) {
      const Command command = obeyed_tick(bridge);
      if (command.utime == (k - 1) * kPeriod + kPeriod + kDelay && k > 0) {
        EXPECT_LT((command.theta - ramp(k - 1).theta).norm(), 1e-12) << k;
        EXPECT_LT((command.velocity - ramp(k - 1).velocity).norm(), 1e-9) << k;
      }
      EXPECT_FALSE(command.limited);
    }
    EXPECT_EQ(bridge.path_rate(), 1);
  }
}

TEST_F(Bridging, InTheLinearShapeItInterpolatesLinearly) {
  Bridge bridge(chain_, {.shape = BridgeOptions::Shape::kLinear});
  EXPECT_TRUE(bridge.measured(at(start_)));
  for (int64_t k = 0; k < 10; ++k) {
    Setpoint setpoint = ramp(k);
    setpoint.theta = start_ + static_cast<double>(k) * slope_;
    EXPECT_EQ(give(bridge, setpoint), SetpointVerdict::kAccepted);
    for (int64_t ms = 0; ms < 50; ++ms) {
      const Command command = obeyed_tick(bridge);
      const double time = static_cast<double>(command.utime - kPeriod - kDelay) / static_cast<double>(kPeriod);
      const JointVector expected = start_ + std::max(time, 0.0) * slope_;
      EXPECT_LT((command.theta - expected).cwiseAbs().maxCoeff(), 1e-12) << command.utime;
    }
  }
}

TEST_F(Bridging, OneLostSetpointIsNotFelt) {
  // The motion of one that got all, in comparison.
  double largest = 0;
  Bridge all = running(14), lost = running(14);
  for (int64_t k = 15; k < 30; ++k) {
    EXPECT_EQ(give(all, ramp(k)), SetpointVerdict::kAccepted);
    if (k != 20) {
      EXPECT_EQ(give(lost, ramp(k)), SetpointVerdict::kAccepted);
    }
    for (int ms = 0; ms < 50; ++ms)
      largest = std::max(largest, (obeyed_tick(all).theta - obeyed_tick(lost).theta).norm());
  }
  EXPECT_LT(largest, 1e-9) << "the velocity is constant, and set-points carry it";
}

TEST_F(Bridging, AMotionThatBeganWithALateSetpointBeginsAgain) {
  // The first one comes 61 ms late, the others at once or 1 ms late: half of them are too far in the future for its
  // time, but the others are not, and would keep the motion alive.
  Bridge bridge(chain_, {});
  EXPECT_TRUE(bridge.measured(at(start_)));
  const int64_t late = BridgeOptions{}.max_setpoint_lead_us / 1000 + 1;
  Command command;
  const auto tick_until = [&](int64_t ms) {
    for (static int64_t now = late; now < ms; ++now) command = obeyed_tick(bridge);
  };
  int64_t refused = 0;
  for (int64_t k = 0; k < 60; ++k) {
    Setpoint setpoint = ramp(0);
    setpoint.utime = k * kPeriod;
    setpoint.sequence = k;
    setpoint.velocity.setZero();
    tick_until(k * 50 + k % 2);
    refused += give(bridge, setpoint) != SetpointVerdict::kAccepted;
  }
  EXPECT_EQ(bridge.state(), BridgeState::kRunning);
  EXPECT_LE(refused, 10);
  EXPECT_LE(std::abs(*bridge.next_tick() - 59 * kPeriod), 2000) << "the time of the set-points";
}

TEST_F(Bridging, WhenSetpointsStopItDeceleratesAndIsReadyForAnotherController) {
  Bridge bridge = running(20);
  StreamCheck check(bridge.limits());
  Command command;
  for (int ms = 0; ms < 1000; ++ms) {
    command = obeyed_tick(bridge);
    check.add(command.theta);
  }
  EXPECT_TRUE(check.keeps());
  EXPECT_TRUE(command.holding);
  EXPECT_EQ(command.velocity.norm(), 0);
  EXPECT_EQ(bridge.state(), BridgeState::kArmed);
  Setpoint other = ramp(0);
  other.run = 99;
  other.theta = command.theta;
  other.utime = 77000000000;
  bool restarted = false;
  EXPECT_EQ(bridge.setpoint(other, restarted), SetpointVerdict::kAccepted);
  EXPECT_TRUE(restarted);
  EXPECT_EQ(*bridge.next_tick(), other.utime);
  EXPECT_EQ(bridge.tick().theta, command.theta);
}

TEST_F(Bridging, RefusesEachBadSetpointUnderItsName) {
  Bridge bridge = running(20);
  const Setpoint good = ramp(21);
  const auto changed = [&good](const std::function<void(Setpoint&)>& change) {
    Setpoint setpoint = good;
    change(setpoint);
    return setpoint;
  };
  EXPECT_EQ(give(bridge, changed([](Setpoint& s) { s.theta[0] = NAN; })), SetpointVerdict::kInvalid);
  EXPECT_EQ(give(bridge, changed([](Setpoint& s) { s.theta = JointVector::Zero(5); })), SetpointVerdict::kInvalid);
  EXPECT_EQ(give(bridge, changed([](Setpoint& s) { s.velocity[1] = 1.7e308; })), SetpointVerdict::kInvalid);
  EXPECT_EQ(give(bridge, changed([](Setpoint& s) { s.run = 5; })), SetpointVerdict::kOtherRun);
  EXPECT_EQ(give(bridge, ramp(20)), SetpointVerdict::kNotNewer) << "a duplicate";
  EXPECT_EQ(give(bridge, ramp(19)), SetpointVerdict::kNotNewer) << "out of order";
  EXPECT_EQ(give(bridge, changed([](Setpoint& s) { s.utime += 900000; })), SetpointVerdict::kTooEarly);
  EXPECT_EQ(give(bridge, changed([](Setpoint& s) { s.theta[2] += 1; })), SetpointVerdict::kTooFast);
  EXPECT_EQ(give(bridge, changed([](Setpoint& s) { s.velocity[2] = 100; })), SetpointVerdict::kTooFast);
  for (int ms = 0; ms < 200; ++ms) obeyed_tick(bridge);
  EXPECT_EQ(give(bridge, good), SetpointVerdict::kTooOld);
  Bridge fresh(chain_, {});
  EXPECT_TRUE(fresh.measured(at(start_)));
  EXPECT_EQ(give(fresh, changed([this](Setpoint& s) { s.theta[0] = start_[0] + 0.2; })),
            SetpointVerdict::kFarFromRobot);
  EXPECT_EQ(give(fresh, changed([this](Setpoint& s) {
                   s.theta = start_;
                   s.velocity[0] = 10;
                 })),
            SetpointVerdict::kTooFast)
      << "also the first";
  Measurement moving = at(start_);
  moving.velocity[0] = 1;
  EXPECT_TRUE(fresh.measured(moving));
  EXPECT_EQ(give(fresh, ramp(0)), SetpointVerdict::kFarFromRobot) << "the robot moves";
}

TEST_F(Bridging, RefusesMeasurementsThatAreNotFiniteOrOfAnotherSizeOrRobot) {
  Bridge bridge(chain_, {});
  JointVector bad = start_;
  bad[0] = NAN;
  EXPECT_FALSE(bridge.measured(at(bad)));
  EXPECT_FALSE(bridge.measured(at(JointVector::Zero(3))));
  EXPECT_THROW(Bridge(chain_, {.delay_us = 4 * kPeriod}), std::invalid_argument);
  EXPECT_THROW(Bridge(chain_, {.period_us = 0}), std::invalid_argument);
  EXPECT_THROW(Bridge(chain_, {.delay_us = -1}), std::invalid_argument);
  EXPECT_THROW(Bridge(chain_, {.acceleration = JointVector::Zero(4)}), std::invalid_argument);
  Bridge other = running(3);
  EXPECT_FALSE(other.measured(at(start_, 0, 77))) << "a second robot";
  EXPECT_EQ(other.state(), BridgeState::kRunning);
}

TEST_F(Bridging, AReorderedOrRepeatedMeasurementIsNoJump) {
  Bridge bridge = running(20);
  MeasurementVerdict verdict{};
  const Command before = obeyed_tick(bridge);
  for (int ms = 0; ms < 60; ++ms) {
    if (ms == 0 || ms == 50) (void)give(bridge, ramp(21 + ms / 50));
    obeyed_tick(bridge);
  }
  const Command now = bridge.tick();
  // Of 62 ms ago, and further from now than a robot can go in no time.
  Measurement old = at(before.theta + JointVector::Constant(4, 0.2), before.utime);
  for (int k = 0; k < 5; ++k) {
    EXPECT_FALSE(bridge.measured(old, verdict));
    EXPECT_EQ(verdict, MeasurementVerdict::kOlder);
  }
  EXPECT_TRUE(bridge.measured(at(now.theta, now.utime)));
  EXPECT_TRUE(bridge.measured(at(now.theta, now.utime))) << "it came twice";
  obeyed_tick(bridge);
  EXPECT_EQ(bridge.state(), BridgeState::kRunning) << bridge.cause();
  // A robot whose clock is set back by more than a second goes on.
  EXPECT_TRUE(bridge.measured(at(bridge.tick().theta, now.utime - 2000000)));
}

TEST_F(Bridging, NoTimeOverflows) {
  const std::array<int64_t, 6> times{INT64_MIN, INT64_MIN + 1, -1, 0, INT64_MAX - 1, INT64_MAX};
  for (const int64_t first : times) {
    for (const int64_t second : times) {
      Bridge bridge(chain_, {});
      EXPECT_TRUE(bridge.measured(at(start_, first)));
      Setpoint setpoint = ramp(0);
      setpoint.utime = second;
      if (give(bridge, setpoint) != SetpointVerdict::kAccepted) (void)give(bridge, ramp(0));
      ASSERT_TRUE(bridge.next_tick());
      setpoint = ramp(1);
      setpoint.utime = first;
      (void)give(bridge, setpoint);
      for (int ms = 0; ms < 3; ++ms) {
        bridge.tick();
        (void)bridge.measured(at(start_, second));
      }
      EXPECT_NE(bridge.state(), BridgeState::kFault);
    }
  }
}

TEST_F(Bridging, OneMeasurementOfAnotherRobotChangesNothing) {
  // Before a motion: a real robot that is heard once would have to be enabled.
  Bridge bridge(chain_, {});
  EXPECT_TRUE(bridge.measured(at(start_)));
  Measurement other = at(start_, 0, 77);
  other.real = true;
  MeasurementVerdict verdict{};
  for (int k = 0; k < 100; ++k) {
    EXPECT_FALSE(bridge.measured(other, verdict));
    EXPECT_EQ(verdict, MeasurementVerdict::kOtherRobot);
    EXPECT_TRUE(bridge.measured(at(start_)));
  }
  EXPECT_EQ(bridge.state(), BridgeState::kArmed);
  EXPECT_EQ(bridge.followed_robot(), kRobot);
  // During one, while the robot's states are late: it goes on once they come, and no fault is latched.
  Bridge late = running(20);
  for (int ms = 0; ms < 150; ++ms) late.tick();
  EXPECT_EQ(late.state(), BridgeState::kStopping);
  EXPECT_FALSE(late.measured(other));
  obeyed_tick(late);
  EXPECT_NE(late.state(), BridgeState::kFault);
  // The other one is followed when the first is gone.
  for (int k = 0; k < 9; ++k) EXPECT_FALSE(bridge.measured(other));
  EXPECT_TRUE(bridge.measured(other));
  EXPECT_EQ(bridge.followed_robot(), 77);
  EXPECT_EQ(bridge.state(), BridgeState::kIdle) << "it is real";
}

TEST_F(Bridging, AShortGapIsBridgedAndAfterALongOneTheStreamBeginsFromRest) {
  Bridge bridge = running(20);
  const Command before = obeyed_tick(bridge);
  EXPECT_EQ(give(bridge, ramp(21)), SetpointVerdict::kAccepted);
  bridge.skip(3);
  const Command after = bridge.tick();
  EXPECT_EQ(after.utime, before.utime + 4000);
  EXPECT_LT((after.theta - before.theta - 4e-3 * before.velocity).norm(), 1e-6) << "at the last velocity";

  bridge.skip(1000);
  const Command rested = bridge.tick();
  EXPECT_EQ(rested.utime, after.utime + 1001000);
  EXPECT_EQ(rested.theta, after.theta);
  EXPECT_EQ(rested.velocity.norm(), 0);
  EXPECT_EQ(bridge.state(), BridgeState::kArmed);
  Setpoint next = ramp(42);
  EXPECT_EQ(give(bridge, next), SetpointVerdict::kFarFromRobot) << "no measurement since the gap";
  EXPECT_TRUE(bridge.measured(at(rested.theta)));
  StreamCheck check(bridge.limits());
  for (int ms = 0; ms < 500; ++ms) {
    EXPECT_EQ(give(bridge, next), SetpointVerdict::kFarFromRobot) << "which asks the controller to start again";
    check.add(obeyed_tick(bridge).theta);
  }
  next = ramp(52);  // half a second later
  EXPECT_EQ(give(bridge, next), SetpointVerdict::kAccepted) << "the same controller goes on";
  for (int64_t k = 53; k < 90; ++k) {
    for (int ms = 0; ms < 50; ++ms) check.add(obeyed_tick(bridge).theta);
    EXPECT_EQ(give(bridge, ramp(k)), SetpointVerdict::kAccepted);
  }
  EXPECT_TRUE(check.keeps()) << check.velocity() << " " << check.acceleration() << " " << check.jerk();
  EXPECT_EQ(bridge.path_rate(), 1) << "and has caught up";
}

TEST_F(Bridging, AfterAGapShorterThanTheRobotsTimeoutItGoesOnAtOnceFromRest) {
  Bridge bridge = running(20);
  const Command before = obeyed_tick(bridge);
  bridge.skip(10);
  StreamCheck check(bridge.limits());
  Command command = obeyed_tick(bridge);
  check.add(before.theta);
  check.add(command.theta);
  EXPECT_EQ(bridge.state(), BridgeState::kRunning);
  for (int64_t k = 21; k < 40; ++k) {
    EXPECT_EQ(give(bridge, ramp(k)), SetpointVerdict::kAccepted);
    for (int ms = 0; ms < 50; ++ms) check.add((command = obeyed_tick(bridge)).theta);
  }
  EXPECT_TRUE(check.keeps()) << check.velocity() << " " << check.acceleration() << " " << check.jerk();
  const double k = static_cast<double>(command.utime - kPeriod - kDelay) / static_cast<double>(kPeriod);
  EXPECT_LT((command.theta - (start_ + (k - 5) * slope_)).norm(), 1e-9) << "and has caught up";
}

TEST_F(Bridging, TheSpeedOverrideSlowsDownAlongThePathAndPauses) {
  Bridge bridge = running(20);
  StreamCheck check(bridge.limits());
  bridge.set_speed(0.5);
  for (int64_t k = 21; k < 40; ++k) {
    EXPECT_EQ(give(bridge, ramp(k)), SetpointVerdict::kAccepted);
    for (int ms = 0; ms < 50; ++ms) check.add(obeyed_tick(bridge).theta);
    if (k < 27) continue;  // it slows down within a quarter of a second
    EXPECT_LE(bridge.path_rate(), 0.5);
    EXPECT_GT(bridge.path_rate(), 0.3);
  }
  bridge.pause(true);
  Command command;
  for (int64_t k = 40; k < 50; ++k) {
    EXPECT_EQ(give(bridge, ramp(k)), SetpointVerdict::kAccepted);
    for (int ms = 0; ms < 50; ++ms) check.add((command = obeyed_tick(bridge)).theta);
  }
  EXPECT_EQ(command.velocity.norm(), 0);
  EXPECT_EQ(bridge.path_rate(), 0);
  EXPECT_EQ(bridge.state(), BridgeState::kRunning);
  bridge.pause(false);
  EXPECT_EQ(give(bridge, ramp(50)), SetpointVerdict::kAccepted);
  for (int ms = 0; ms < 20; ++ms) check.add((command = obeyed_tick(bridge)).theta);
  EXPECT_GT(command.velocity.norm(), 0);
  EXPECT_TRUE(check.keeps()) << check.velocity() << " " << check.acceleration() << " " << check.jerk();
}

TEST_F(Bridging, ASlowerSpeedDoesNotOvershootAFastMotion) {
  // The bridge slows down to a tenth while every joint moves at 5 rad/s towards set-points that slow down with it.
  std::vector<Joint> joints = chain_.joints();
  std::vector<Eigen::Isometry3d> fixed;
  for (int i = 0; i <= chain_.size(); ++i) fixed.push_back(chain_.fixed(i));
  for (Joint& joint : joints) {
    joint.lower = -100;
    joint.upper = 100;
  }
  Bridge bridge(Chain(joints, fixed, chain_.base(), chain_.tip()), {});
  JointVector theta = JointVector::Zero(4), goal = theta;
  EXPECT_TRUE(bridge.measured(at(theta)));
  double speed = 0;
  for (int64_t k = 0; k < 80; ++k) {
    if (k == 30) bridge.set_speed(0.1);
    speed = std::min(5.0, speed + 1);
    const double moved = speed * bridge.setpoint_rate();
    goal = goal + JointVector::Constant(4, 0.05 * moved);
    EXPECT_EQ(give(bridge, {.run = kController,
                            .utime = k * kPeriod,
                            .sequence = k,
                            .theta = goal,
                            .velocity = JointVector::Constant(4, moved)}),
              SetpointVerdict::kAccepted);
    for (int ms = 0; ms < 50; ++ms) {
      const Command command = obeyed_tick(bridge);
      EXPECT_GE(command.velocity.minCoeff(), -1e-9) << "it never moves backwards, set-point " << k;
      EXPECT_LE(command.theta[0], goal[0] + 0.02) << "nor far beyond its goal, set-point " << k;
    }
  }
}

TEST_F(Bridging, TheTickAllocatesNothing) {
  Bridge bridge = running(2);
  const int64_t before = testing::allocations().number;
  for (int64_t k = 3; k < 20; ++k) {
    EXPECT_EQ(give(bridge, ramp(k)), SetpointVerdict::kAccepted);
    for (int ms = 0; ms < 50; ++ms) obeyed_tick(bridge);
  }
  EXPECT_EQ(testing::allocations().number, before);
}

}  // namespace
}  // namespace multireach::robot_bridge
