// The motion generator keeps all limits for any goals at any times: judged by finite differences of its positions.
#include "robot_bridge/motion_generator.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <iostream>

#include "numeric/random.hpp"
#include "robot_bridge/stream_check.hpp"
#include "tests/allocation_count.hpp"
#include "tests/test_arms.hpp"

namespace multireach::robot_bridge {
namespace {

constexpr double kPeriod = 1e-3;

TEST(MotionGenerator, KeepsAllLimitsForAnyGoalsAtAnyTime) {
  constexpr uint64_t kSeed = 20261122;
  std::cout << "seed " << kSeed << "\n";
  const Chain chain = testing::hoap2();
  const MotionLimits limits = motion_limits(chain, 3, {}, {});
  const int n = chain.size();
  const CounterRandom random(kSeed);
  const auto uniform = [&random](uint64_t run, uint64_t time, uint64_t what) {
    return random.uniform((run << 40) + (time << 8) + what);
  };
  int64_t moved = 0, refused = 0, stops = 0;
  for (uint64_t run = 0; run < 40; ++run) {
    MotionGenerator generator(limits, kPeriod);
    JointVector start(n);
    for (int i = 0; i < n; ++i) {
      start[i] = chain.sample_lower(i) +
                 uniform(run, 0, static_cast<uint64_t>(i)) * (chain.sample_upper(i) - chain.sample_lower(i));
    }
    generator.rest_at(start);
    StreamCheck check(limits);
    const double scale = std::pow(10.0, -2.5 * uniform(run, 1, 0));  // from tiny steps to the whole range
    for (uint64_t ms = 0; ms < 3000; ++ms) {
      const auto draw = [&](uint64_t what) { return uniform(run, 2 + ms, what); };
      if (draw(0) < 0.02) {
        MotionState goal = generator.state();
        for (int i = 0; i < n; ++i) {
          const auto joint = 10 * static_cast<uint64_t>(i);
          goal.position[i] += scale * (draw(10 + joint) - 0.5) * (limits.upper[i] - limits.lower[i]);
          goal.velocity[i] = 2 * scale * (draw(11 + joint) - 0.5) * limits.velocity[i];
          goal.acceleration[i] = 2 * scale * (draw(12 + joint) - 0.5) * limits.acceleration[i];
        }
        ++(generator.move_to(goal, 0.005 + 0.1 * draw(1)) > 0 ? moved : refused);
      }
      if (draw(2) < 0.005) {
        generator.stop();
        ++stops;
      }
      if (generator.finished()) generator.stop();
      generator.advance();
      check.add(generator.state().position);
    }
    ASSERT_TRUE(check.keeps()) << "run " << run << ": " << check.velocity() << " " << check.acceleration() << " "
                               << check.jerk() << " " << check.excess();
  }
  std::cout << moved << " motions, " << refused << " refused, " << stops << " stops\n";
  EXPECT_GT(moved, 1000);
  EXPECT_LT(refused, moved) << "the motion never stops for good";
}

TEST(MotionGenerator, TheCheckRejectsAStepAndARamp) {
  const MotionLimits limits = motion_limits(testing::hoap2(), 3, {}, {});
  StreamCheck step(limits), ramp(limits);
  for (int k = 0; k < 10; ++k) {
    step.add(JointVector::Constant(4, k < 5 ? 0.0 : 0.1));
    ramp.add(JointVector::Constant(4, -0.3 - 0.001 * std::max(k - 5, 0)));
  }
  EXPECT_GT(step.velocity(), 10);
  EXPECT_LT(ramp.velocity(), 1);
  EXPECT_GT(ramp.acceleration(), 10) << "a motion that starts at full speed";
}

TEST(MotionGenerator, ReachesAGoalInTimeAndFollowsASineWithoutSlowingDown) {
  const Chain chain = testing::hoap2();
  const MotionLimits limits = motion_limits(chain, 3, {}, {});
  MotionGenerator generator(limits, kPeriod);
  const auto on_path = [&](double t) {
    const JointVector middle = (limits.lower + limits.upper) / 2;
    const JointVector amplitude = JointVector::Constant(4, 0.3);
    const double w = 5;
    return MotionState{middle + amplitude * (1 - std::cos(w * t)), amplitude * w * std::sin(w * t),
                       amplitude * w * w * std::cos(w * t)};
  };
  generator.rest_at(on_path(0).position);
  // The acceleration starts at 7.5 rad/s^2 at once, which a limited jerk cannot follow; afterwards the sine is smooth.
  double error = 0;
  for (int k = 1; k < 60; ++k) {
    const double rate = generator.move_to(on_path(0.05 * k), 0.05);
    if (k > 1) {
      EXPECT_EQ(rate, 1) << "segment " << k;
    }
    for (int ms = 1; ms <= 50; ++ms) {
      generator.advance();
      if (k > 3)
        error = std::max(error, (generator.state().position - on_path(0.05 * (k - 1) + 1e-3 * ms).position).norm());
    }
  }
  // A quintic Hermite polynomial deviates from a function by h^6 / 46080 of its sixth derivative.
  EXPECT_LT(error, 2 * 0.3 * std::pow(5 * 0.05, 6) / 46080 + 1e-12);
}

TEST(MotionGenerator, FromOutsideTheLimitsItOnlyComesBack) {
  const MotionLimits limits = motion_limits(testing::hoap2(), 3, {}, {});
  MotionGenerator generator(limits, kPeriod);
  JointVector outside = (limits.lower + limits.upper) / 2;
  outside[1] = limits.upper[1] + 0.3;
  generator.rest_at(outside);
  MotionState goal = MotionState::at_rest(outside);
  goal.position[1] += 1;
  EXPECT_GT(generator.move_to(goal, 0.05), 0);
  double excess = 0.3;
  for (int ms = 0; ms < 3000; ++ms) {
    generator.advance();
    EXPECT_LE(generator.state().position[1] - limits.upper[1], excess + 1e-12);
    excess = generator.state().position[1] - limits.upper[1];
  }
  EXPECT_LE(excess, 1e-9);
}

TEST(MotionGenerator, ChecksTheAccelerationWhereTheJerkIsLinear) {
  // The acceleration of this segment is a parabola with its peak, 67.5 rad/s^2, in the middle.
  const MotionLimits limits =
      motion_limits(testing::hoap2(), 3, JointVector::Constant(4, 60), JointVector::Constant(4, 6000));
  const MotionState start = MotionState::at_rest((limits.lower + limits.upper) / 2);
  MotionState end = start;
  end.position[3] += 0.05625;
  end.velocity[3] = 2.25;
  EXPECT_FALSE(QuinticSegment(start, end, 0.05).keeps(limits, kPeriod));
}

// What QuinticSegment::keeps says of joints far from their limits without looking at any time follows from these.
TEST(MotionGenerator, AStopTakesAndMovesNoMoreThanItsBounds) {
  constexpr uint64_t kSeed = 7;
  std::cout << "seed " << kSeed << "\n";
  const CounterRandom random(kSeed);
  double longest = 0, furthest = 0, fastest = 0;  // shares of the bounds
  for (uint64_t k = 0; k < 100000; ++k) {
    const auto draw = [&](uint64_t what) { return random.uniform(8 * k + what); };
    const double A = std::pow(10.0, 3 * draw(0) - 1), J = A * std::pow(10.0, 4 * draw(1) - 1);
    const double v = std::pow(10.0, 3 * draw(2) - 2), a = A * (draw(3) < 0.2 ? 1 : 2 * draw(4) - 1);
    const JointVector one = JointVector::Ones(1);
    const MotionLimits limits{-1e6 * one, 1e6 * one, 1e6 * one, A * one, J * one};
    bool feasible = false;
    const StopProfile stop = stop_profile(limits, 0, 0, v, a, feasible);
    const double T = stop.duration_s, change = std::abs(a);
    const double jerk_bound = (4 * change + std::sqrt(16 * change * change + 24 * J * v)) / (2 * J);
    longest = std::max(longest, T / std::max(jerk_bound, 1.1 * 3 / std::sqrt(2.0) * v / A));
    for (int i = 1; i <= 100; ++i) {
      double q = 0, speed = 0, acceleration = 0;
      stop.at(0.01 * i * T, q, speed, acceleration);
      furthest = std::max(furthest, std::abs(q) / (T * (v / 2 + T * change / 12)));
      fastest = std::max(fastest, std::abs(speed) / (v + 4.0 / 27 * T * change));
    }
  }
  std::cout << "of the bounds: " << longest << " of the time, " << furthest << " of the way, " << fastest
            << " of the speed\n";
  EXPECT_LE(longest, 1 + 1e-6);
  EXPECT_GT(longest, 0.95) << "the bound is close";
  EXPECT_LE(furthest, 1 + 1e-9);
  EXPECT_LE(fastest, 1 + 1e-9);
}

TEST(MotionGenerator, AllocatesNothing) {
  const MotionLimits limits = motion_limits(testing::hoap2(), 3, {}, {});
  MotionGenerator generator(limits, kPeriod);
  generator.rest_at((limits.lower + limits.upper) / 2);
  MotionState goal = generator.state();
  goal.position[0] += 0.01;
  const int64_t before = testing::allocations().number;
  generator.move_to(goal, 0.05);
  for (int ms = 0; ms < 60; ++ms) generator.advance();
  generator.stop();
  generator.advance();
  EXPECT_EQ(testing::allocations().number, before);
}

}  // namespace
}  // namespace multireach::robot_bridge
