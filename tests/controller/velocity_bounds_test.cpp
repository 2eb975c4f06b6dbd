#include "controller/qp/velocity_bounds.hpp"

#include <gtest/gtest.h>

#include "numeric/random.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 5;
constexpr double kRate = 0.0426, kInfinity = std::numeric_limits<double>::infinity();

TEST(VelocityBounds, WhateverIsChosenInsideThemNeitherPositionNorSpeedNorAccelerationIsEverExceeded) {
  const CounterRandom random(kSeed);
  const BarrierRate rate(kRate);
  uint64_t counter = 0;
  for (int run = 0; run < 300; ++run) {
    const double lower = -1, upper = lower + random.uniform(counter, 0, 2);
    const double speed = random.uniform(counter + 1, 0.001, 0.05),
                 acceleration = random.uniform(counter + 2, 1e-5, 2e-3);
    counter += 3;
    double position = random.uniform(counter++, lower, upper), velocity = 0;
    for (int step = 0; step < 2000; ++step) {
      const VelocityBounds<double> range =
          velocity_bounds<double>(position, velocity, lower, upper, speed, acceleration, rate);
      ASSERT_LE(range.lower, range.upper);
      // Mostly the extremes, because these reveal a wrong bound.
      const double part = random.uniform(counter++);
      const bool outwards = (step / 200) % 2 == 0;
      const double chosen = part < 0.8 ? (outwards ? range.upper : range.lower)
                                       : range.lower + (range.upper - range.lower) * random.uniform(counter++);
      ASSERT_LE(std::abs(chosen), speed);
      ASSERT_LE(std::abs(chosen - velocity), acceleration * (1 + 1e-9)) << "seed " << kSeed << ", run " << run;
      velocity = chosen;
      position += velocity;
      ASSERT_GE(position, lower - 1e-12) << "seed " << kSeed << ", run " << run << ", step " << step;
      ASSERT_LE(position, upper + 1e-12) << "seed " << kSeed << ", run " << run << ", step " << step;
    }
  }
}

TEST(VelocityBounds, TheBarrierIsTheLargestVelocityThatIsStillSafeAfterTheStep) {
  for (const double a : {1e-4, 2e-3, kInfinity}) {
    const auto safe = [&](double s) {
      return s <= a / (kRate * kRate) ? kRate * s : std::sqrt(2 * a * s - a * a / (kRate * kRate));
    };
    for (const double s : {0.0, 1e-6, 0.01, 0.1, 0.7, 3.0}) {
      const double v = barrier(s, BarrierRate(kRate), a);
      EXPECT_NEAR(v, safe(s - v), 1e-12) << s << " " << a;
    }
  }
}

TEST(VelocityBounds, FromOutsideALimitTheJointComesBackMonotonicallyAndNotOutOnTheOtherSide) {
  const BarrierRate rate(kRate);
  for (const double acceleration : {1e-5, 1e-4, kInfinity}) {
    for (const double lower : {-1.0, 1.0}) {
      for (const bool slowly : {true, false}) {
        double position = 1.5, velocity = 0;
        for (int step = 0; step < 3000; ++step) {
          const VelocityBounds<double> range =
              velocity_bounds<double>(position, velocity, lower, 1, 0.02, acceleration, rate);
          const double chosen = slowly ? range.upper : range.lower;
          ASSERT_GE(chosen, -0.02);
          ASSERT_LE(std::abs(chosen - velocity), acceleration * (1 + 1e-9));
          velocity = chosen;
          ASSERT_TRUE(position <= 1 || velocity <= 0);
          position += velocity;
          ASSERT_GE(position, lower - 1e-12);
        }
        EXPECT_LT(position, 1 + 1e-6);
      }
    }
  }
}

TEST(VelocityBounds, TheJointsOwnAttractorAlwaysSatisfiesThem) {
  // As docs/guarantees.md states for alpha (1 - beta)^2 >= 4 beta (1 - alpha): from rest, for any target inside the
  // limits.
  const double alpha = 0.08, beta = 0.02;
  const BarrierRate rate(alpha * (1 - beta) / (2 * (1 - alpha)));
  const CounterRandom random(kSeed);
  uint64_t counter = 0;
  for (int run = 0; run < 200; ++run) {
    double position = random.uniform(counter++, -1, 1), velocity = 0, target = 0;
    for (int step = 0; step < 1000; ++step) {
      if (step % 50 == 0) target = random.uniform(counter++) < 0.5 ? -1 : 1;
      const VelocityBounds<double> range =
          velocity_bounds<double>(position, velocity, -1, 1, kInfinity, kInfinity, rate);
      velocity += alpha * (-velocity + beta * (target - position));
      ASSERT_LE(velocity, range.upper + 1e-15);
      ASSERT_GE(velocity, range.lower - 1e-15);
      position += velocity;
    }
  }
}

TEST(VelocityBounds, AnEmptyRangeHoldsTheJointAndInfiniteOnesLeaveItFree) {
  const BarrierRate rate(kRate);
  const VelocityBounds<double> held = velocity_bounds<double>(0.3, 0, 0.3, 0.3, 1, kInfinity, rate);
  EXPECT_EQ(held.lower, 0);
  EXPECT_EQ(held.upper, 0);
  const VelocityBounds<double> open = velocity_bounds<double>(7, 0, -kInfinity, kInfinity, kInfinity, kInfinity, rate);
  EXPECT_EQ(open.lower, -kInfinity);
  EXPECT_EQ(open.upper, kInfinity);
}

}  // namespace
}  // namespace multireach::controller
