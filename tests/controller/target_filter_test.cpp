#include "controller/target_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "numeric/gaussian.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 31;
const Eigen::Vector3d kPosition(0.1, -0.2, 0.3);

TEST(TargetFilter, PassesExactPositionsUnchanged) {
  TargetFilter filter({});
  EXPECT_TRUE(filter.update({.utime = 0, .seen = true, .position = kPosition})) << "the first is a new target";
  for (int k = 1; k < 50; ++k) {
    const Eigen::Vector3d position = kPosition + Eigen::Vector3d(0.001 * k, 0, 0);
    EXPECT_FALSE(filter.update({.utime = 33333 * k, .seen = true, .position = position}));
    EXPECT_EQ(filter.position_at(33333 * k), position);
  }
}

TEST(TargetFilter, IsCarriedAlongByTheVelocity) {
  TargetFilter filter({});
  filter.update({.utime = 1000, .seen = true, .position = kPosition, .velocity = {1, 0, -2}});
  EXPECT_LT((filter.position_at(501000) - (kPosition + Eigen::Vector3d(0.5, 0, -1))).norm(), 1e-15);
}

TEST(TargetFilter, ANoisyRestingTargetIsKnownBetterThanAnyOfItsMeasurements) {
  const CounterRandom random(kSeed);
  uint64_t counter = 0;
  const double sigma = 0.005;
  TargetFilter filter({.wander_m_per_root_s = 0.002});
  double sum = 0;
  int jumps = 0, number = 0;
  for (int k = 0; k < 3000; ++k) {
    Eigen::Vector3d seen = kPosition;
    for (double& coordinate : seen) coordinate += sigma * gaussian(random, counter);
    jumps += filter.update({.utime = 33333 * k,
                            .seen = true,
                            .position = seen,
                            .covariance = sigma * sigma * Eigen::Matrix3d::Identity()});
    if (k < 100) continue;
    sum += (filter.position_at(33333 * k) - kPosition).squaredNorm();
    ++number;
  }
  EXPECT_LT(std::sqrt(sum / number / 3), 0.4 * sigma) << "seed " << kSeed;
  EXPECT_LE(jumps, 2) << "the first, and hardly a match beyond four sigma";
}

TEST(TargetFilter, ALeapIsANewTarget) {
  TargetFilter filter({.jump_m = 0.02});
  filter.update({.utime = 0, .seen = true, .position = kPosition});
  EXPECT_FALSE(filter.update({.utime = 1, .seen = true, .position = kPosition + Eigen::Vector3d(0.019, 0, 0)}));
  EXPECT_TRUE(filter.update({.utime = 2, .seen = true, .position = kPosition + Eigen::Vector3d(0.05, 0, 0)}));
}

TEST(TargetFilter, ACovarianceThatIsNoneIsNoKnowledge) {
  for (const double bad : {double(NAN), -1.0, double(INFINITY), 1e9}) {
    TargetFilter filter({});
    filter.update({.utime = 0, .seen = true, .position = kPosition});
    const Eigen::Vector3d position = kPosition + Eigen::Vector3d(0.01, 0, 0);
    filter.update({.utime = 1, .seen = true, .position = position, .covariance = bad * Eigen::Matrix3d::Identity()});
    EXPECT_EQ(filter.position_at(1), position) << bad;
  }
}

TEST(TargetFilter, AnIndefiniteCovarianceIsNoKnowledgeEither) {
  Eigen::Matrix3d indefinite = Eigen::Matrix3d::Constant(0.9);
  indefinite.diagonal().setConstant(1e-6);
  ASSERT_GT(indefinite.determinant(), 0) << "which the determinant alone does not tell";
  TargetFilter filter({});
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d position = kPosition + Eigen::Vector3d(0.002 * (k % 3), 0, 0);
    EXPECT_EQ(filter.update({.utime = 33333 * k, .seen = true, .position = position, .covariance = indefinite}),
              k == 0);
    EXPECT_EQ(filter.position_at(33333 * k), position);
  }
}

constexpr int64_t kPeriod = 33333;
const Eigen::Vector3d kVelocity(0.1, 0.2, -0.1), kAcceleration(0.5, -1, 0.3);

/// Of a target that accelerates steadily, the k-th of 30 a second.
TargetObservation observation(int64_t k) {
  const double t = 1e-6 * static_cast<double>(k * kPeriod);
  return {.utime = k * kPeriod,
          .seen = true,
          .position = kPosition + kVelocity * t + kAcceleration * (t * t / 2),
          .velocity = kVelocity + kAcceleration * t};
}

TEST(TargetFilter, ASteadyAccelerationIsLearntAndExtrapolated) {
  constexpr double kTime = 0.1;
  TargetFilter filter({.acceleration_s = kTime});
  constexpr int64_t kCount = 40, kAhead = 100000;
  for (int64_t k = 0; k <= kCount; ++k) filter.update(observation(k));
  const double t = 1e-6 * static_cast<double>(kCount * kPeriod + kAhead);
  const Eigen::Vector3d position = kPosition + kVelocity * t + kAcceleration * (t * t / 2);
  const Eigen::Vector3d velocity = kVelocity + kAcceleration * t;
  // What is left of the first estimate, zero, after so many means; and the rounding of times to microseconds.
  const double left = kAcceleration.norm() * std::exp(-1e-6 * kCount * kPeriod / kTime) + 1e-9;
  EXPECT_LT((filter.velocity_at(kCount * kPeriod + kAhead) - velocity).norm(), 0.1 * left);
  EXPECT_LT((filter.position_at(kCount * kPeriod + kAhead) - position).norm(), 0.005 * left);
  // Far ahead the velocity stays as it is after 0.15 s.
  EXPECT_EQ(filter.velocity_at(kCount * kPeriod + 150000), filter.velocity_at(kCount * kPeriod + 900000));
}

TEST(TargetFilter, AJumpForgetsTheAcceleration) {
  TargetFilter filter({.acceleration_s = 0.1});
  for (int64_t k = 0; k < 20; ++k) filter.update(observation(k));
  TargetObservation elsewhere = observation(20);
  elsewhere.position.x() += 1;
  EXPECT_TRUE(filter.update(elsewhere));
  EXPECT_EQ(filter.velocity_at(21 * kPeriod), elsewhere.velocity);
}

TEST(TargetFilter, WithoutItTheVelocityIsConstant) {
  TargetFilter filter({});
  for (int64_t k = 0; k < 20; ++k) filter.update(observation(k));
  const TargetObservation last = observation(19);
  EXPECT_EQ(filter.velocity_at(last.utime + 100000), last.velocity);
  EXPECT_LT((filter.position_at(last.utime + 100000) - (last.position + 0.1 * last.velocity)).norm(), 1e-15);
}

}  // namespace
}  // namespace multireach::controller
