#include "robot_bridge/bridge.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/allocation_count.hpp"
#include "tests/test_arms.hpp"

namespace multireach::robot_bridge {
namespace {

constexpr int64_t kPeriod = 50000, kDelay = 10000;

class Bridging : public ::testing::Test {
 protected:
  Bridging() { start_ << 0.1, -0.5, -0.2, -0.8; }

  /// The k-th set-point of a slow ramp.
  Setpoint ramp(int64_t k) const {
    return {.utime = k * kPeriod, .sequence = k, .theta = start_ + static_cast<double>(k) * slope_};
  }

  Chain chain_ = testing::hoap2();
  JointVector start_{4}, slope_ = JointVector::Constant(4, -0.005);
};

TEST_F(Bridging, IsSilentUntilItKnowsTheRobotAndASetpoint) {
  Bridge bridge(chain_, {});
  EXPECT_FALSE(bridge.next_tick());
  EXPECT_FALSE(bridge.setpoint(ramp(0))) << "where the robot is, is not known";
  EXPECT_FALSE(bridge.next_tick());
  EXPECT_TRUE(bridge.measured(start_));
  EXPECT_FALSE(bridge.next_tick());
  EXPECT_TRUE(bridge.setpoint(ramp(0)));
  EXPECT_EQ(*bridge.next_tick(), 0);
}

TEST_F(Bridging, InterpolatesLinearlyOverOnePeriod) {
  Bridge bridge(chain_, {});
  bridge.measured(start_);
  for (int64_t k = 0; k < 10; ++k) {
    bridge.setpoint(ramp(k));
    for (int64_t ms = 0; ms < 50; ++ms) {
      const Command command = bridge.tick();
      EXPECT_EQ(command.utime, k * kPeriod + 1000 * ms);
      // Set-point j is reached one period and the delay after its time.
      const double at = static_cast<double>(command.utime - kPeriod - kDelay) / static_cast<double>(kPeriod);
      const JointVector expected = start_ + std::max(at, 0.0) * slope_;
      EXPECT_LT((command.theta - expected).cwiseAbs().maxCoeff(), 1e-12) << command.utime;
      EXPECT_FALSE(command.limited);
    }
  }
}

TEST_F(Bridging, AnyDelayLeavesThePositionContinuous) {
  // Set-points come late, early, in bursts, twice, or never.
  const CounterRandom random(4);
  Bridge bridge(chain_, {});
  bridge.measured(start_);
  bridge.setpoint(ramp(0));
  JointVector previous = start_;
  int64_t next = 1;
  for (int64_t ms = 0; ms < 5000; ++ms) {
    const auto draw = static_cast<uint64_t>(ms);
    if (next * 50 <= ms && random.uniform(draw) < 0.05) {
      bridge.setpoint(ramp(next));
      if (random.uniform(draw, 0, 1) < 0.02) bridge.setpoint(ramp(next));
      ++next;
    }
    const Command command = bridge.tick();
    EXPECT_LE((command.theta - previous).cwiseAbs().maxCoeff(), 6e-3 + 1e-12)
        << "no faster than the joints' 6 rad/s, at " << ms;
    previous = command.theta;
  }
}

TEST_F(Bridging, HoldsWhenSetpointsStop) {
  Bridge bridge(chain_, {});
  bridge.measured(start_);
  for (int64_t k = 0; k < 3; ++k) {
    bridge.setpoint(ramp(k));
    for (int ms = 0; ms < 50; ++ms) EXPECT_EQ(bridge.tick().holding, k == 0 && ms < 10);
  }
  Command command;
  for (int ms = 0; ms < 1000; ++ms) command = bridge.tick();
  EXPECT_TRUE(command.holding);
  EXPECT_EQ(command.theta, ramp(2).theta);
  EXPECT_EQ(command.velocity.norm(), 0);
  EXPECT_EQ(command.setpoint_sequence, 2);
}

TEST_F(Bridging, StartsFromTheMeasuredPosture) {
  Bridge bridge(chain_, {});
  JointVector elsewhere(4);
  elsewhere << 0.5, -1.0, 0.1, -1.5;
  bridge.measured(elsewhere);
  bridge.setpoint(ramp(0));
  EXPECT_EQ(bridge.tick().theta, elsewhere);
}

TEST_F(Bridging, NeverFasterThanTheJointsAndNeverBeyondTheirLimits) {
  Bridge bridge(chain_, {});
  bridge.measured(start_);
  JointVector wild(4);
  wild << 10, 10, -10, 10;
  bridge.setpoint({.utime = 0, .sequence = 0, .theta = wild});
  JointVector previous = start_;
  bool limited = false;
  for (int ms = 0; ms < 1500; ++ms) {
    const Command command = bridge.tick();
    EXPECT_LE((command.theta - previous).cwiseAbs().maxCoeff(), 6e-3 + 1e-12);
    EXPECT_EQ(chain_.limit_excess(command.theta), 0);
    previous = command.theta;
    limited |= command.limited;
  }
  EXPECT_TRUE(limited) << "and says so";
  EXPECT_LT((previous - chain_.clamped(wild)).norm(), 1e-12);
}

TEST_F(Bridging, FromOutsideTheLimitsItComesBackMonotonically) {
  Bridge bridge(chain_, {});
  JointVector outside = start_;
  outside[1] = 0.3;
  bridge.measured(outside);
  bridge.setpoint(ramp(0));
  double excess = 0.3;
  for (int ms = 0; ms < 200; ++ms) {
    const double now = chain_.limit_excess(bridge.tick().theta);
    EXPECT_LE(now, excess);
    excess = now;
  }
  EXPECT_EQ(excess, 0);
}

TEST_F(Bridging, RefusesWhatIsNotFiniteOrOfAnotherSize) {
  Bridge bridge(chain_, {});
  JointVector bad = start_;
  bad[0] = NAN;
  EXPECT_FALSE(bridge.measured(bad));
  EXPECT_FALSE(bridge.measured(JointVector::Zero(3)));
  bridge.measured(start_);
  EXPECT_FALSE(bridge.setpoint({.utime = 0, .sequence = 0, .theta = bad}));
  EXPECT_FALSE(bridge.setpoint({.utime = 0, .sequence = 0, .theta = JointVector::Zero(5)}));
  EXPECT_FALSE(bridge.setpoint({.utime = 0, .sequence = 0, .theta = JointVector::Constant(4, 1.7e308)})) << "overflows";
  EXPECT_TRUE(bridge.setpoint(ramp(0)));
  EXPECT_FALSE(bridge.setpoint(ramp(0))) << "a duplicate";
  EXPECT_THROW(Bridge(chain_, {.delay_us = 4 * kPeriod}), std::invalid_argument);
  EXPECT_THROW(Bridge(chain_, {.period_us = 0}), std::invalid_argument);
  EXPECT_THROW(Bridge(chain_, {.delay_us = -1}), std::invalid_argument);
}

TEST_F(Bridging, AnotherTimeLineStartsAtTheSamePosition) {
  Bridge bridge(chain_, {});
  bridge.measured(start_);
  bridge.setpoint(ramp(0));
  Command before;
  for (int ms = 0; ms < 100; ++ms) before = bridge.tick();
  Setpoint restarted = ramp(1);
  restarted.utime = 77000000000;
  EXPECT_TRUE(bridge.setpoint(restarted));
  EXPECT_EQ(*bridge.next_tick(), restarted.utime);
  EXPECT_LT((bridge.tick().theta - before.theta).norm(), 1e-12);
}

TEST_F(Bridging, TheTickAllocatesNothing) {
  Bridge bridge(chain_, {});
  bridge.measured(start_);
  const Setpoint first = ramp(0);
  bridge.setpoint(first);
  const int64_t before = testing::allocations().number;
  for (int64_t k = 1; k < 20; ++k) {
    bridge.setpoint(ramp(k));
    for (int ms = 0; ms < 50; ++ms) bridge.tick();
  }
  EXPECT_EQ(testing::allocations().number, before);
}

}  // namespace
}  // namespace multireach::robot_bridge
