#include "controller/motion_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "controller/target_filter.hpp"
#include "controller/tracking_defaults.hpp"
#include "numeric/gaussian.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 71;
constexpr double kPeriod = 1.0 / 30;

/// A point whose jerk is white noise, integrated in small parts.
struct WhiteJerk {
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero(),
                  acceleration = Eigen::Vector3d::Zero();

  void go_on(double seconds, double jerk_noise, const CounterRandom& random, uint64_t& counter) {
    constexpr int kParts = 200;
    const double h = seconds / kParts;
    for (int k = 0; k < kParts; ++k) {
      Eigen::Vector3d jerk;
      for (double& coordinate : jerk) coordinate = std::sqrt(jerk_noise / h) * gaussian(random, counter);
      position += velocity * h + acceleration * (h * h / 2) + jerk * (h * h * h / 6);
      velocity += acceleration * h + jerk * (h * h / 2);
      acceleration += jerk * h;
    }
  }
};

TEST(MotionFilter, CovarianceMatchesErrors) {
  constexpr double kJerkNoise = 16;
  constexpr int kRuns = 200, kImages = 40;
  Eigen::Matrix3d noise;  // m^2; a stereo pair sees depth worst
  noise << 1e-6, 0, 0.5e-6, 0, 1e-6, 0, 0.5e-6, 0, 9e-6;
  const Eigen::Matrix3d factor = noise.llt().matrixL();
  double sum = 0;
  for (uint64_t run = 0; run < kRuns; ++run) {
    const CounterRandom random(kSeed, run);
    uint64_t counter = 0;
    const auto normal = [&] {
      Eigen::Vector3d v;
      for (double& coordinate : v) coordinate = gaussian(random, counter);
      return v;
    };
    WhiteJerk target;
    target.velocity = 0.4 * normal();  // as the filter expects at first
    target.acceleration = 4 * normal();
    MotionFilter filter;
    filter.begin(target.position + factor * normal(), noise, Eigen::Vector3d::Zero());
    for (int k = 0; k < kImages; ++k) {
      target.go_on(kPeriod, kJerkNoise, random, counter);
      filter.predict(kPeriod, kJerkNoise);
      filter.correct(target.position + factor * normal(), noise);
    }
    Eigen::Matrix<double, 9, 1> error;
    error << filter.position() - target.position, filter.velocity() - target.velocity,
        filter.acceleration() - target.acceleration;
    sum += error.dot(filter.covariance().ldlt().solve(error));
  }
  // The sum is distributed as chi-square of 9 kRuns degrees of freedom: four standard deviations.
  EXPECT_NEAR(sum, 9 * kRuns, 4 * std::sqrt(2.0 * 9 * kRuns)) << "seed " << kSeed;
}

/// Of a target on a circle of 0.13 m in 2 s, at `t` seconds.
Eigen::Vector3d on_circle(double t) {
  return 0.13 * Eigen::Vector3d(std::cos(M_PI * t), std::sin(M_PI * t), 0);
}
Eigen::Vector3d velocity_on_circle(double t) {
  return 0.13 * M_PI * Eigen::Vector3d(-std::sin(M_PI * t), std::cos(M_PI * t), 0);
}

TEST(MotionFilter, TheTargetFilterLearnsTheMotionFromPositionsAlone) {
  for (const int hz : {30, 15, 10}) {
    SCOPED_TRACE(std::to_string(hz) + " Hz");
    TargetFilter filter({.jerk_noise_m2_s5 = kTrackJerkNoise}), without({});
    const int64_t period = 1000000 / hz;
    int64_t last = 0;
    for (int64_t utime = 0; utime < 3000000; utime += period) {
      last = utime;
      const TargetObservation seen{
          .utime = utime, .seen = true, .position = on_circle(1e-6 * static_cast<double>(utime))};
      EXPECT_EQ(filter.update(seen), utime == 0);
      EXPECT_EQ(filter.position_at(utime), seen.position) << "an exact position passes unchanged";
      without.update(seen);
    }
    // The steady filter is near a low pass of third order of w = (q / (R T))^(1/6); a constant jerk j then leaves
    // errors of 2 j / w in the acceleration and 2 j / w^2 in the velocity. A period is added for the sampling.
    const double jerk = 0.13 * std::pow(M_PI, 3), ahead = 0.08, period_s = 1.0 / hz;
    const double w = std::pow(kTrackJerkNoise / (4e-6 * period_s), 1.0 / 6);
    const double velocity = jerk * (2 / (w * w) + period_s / w), acceleration = jerk * (2 / w + period_s);
    const int64_t later = last + 80000;
    const Eigen::Vector3d then = on_circle(1e-6 * static_cast<double>(later));
    EXPECT_LT((filter.velocity_at(last) - velocity_on_circle(1e-6 * static_cast<double>(last))).norm(), velocity);
    EXPECT_LT((filter.position_at(later) - then).norm(),
              velocity * ahead + acceleration * ahead * ahead / 2 + jerk * std::pow(ahead, 3) / 6);
    EXPECT_GT((without.position_at(later) - then).norm(), 0.03) << "by positions alone it lags";
  }
}

TEST(MotionFilter, ATargetThatMovesWhenItIsFirstSeenIsNoOtherOneInTheNextImage) {
  TargetFilter filter({.jerk_noise_m2_s5 = kTrackJerkNoise});
  const Eigen::Vector3d velocity(0.8, 0.6, 0);  // 33 mm between two images
  for (int64_t k = 0; k < 15; ++k) {
    const bool is_new =
        filter.update({.utime = 33333 * k, .seen = true, .position = 0.033333 * static_cast<double>(k) * velocity});
    EXPECT_EQ(is_new, k == 0) << k;
  }
  EXPECT_LT((filter.velocity_at(33333 * 14) - velocity).norm(), 0.02);
  EXPECT_TRUE(filter.update({.utime = 33333 * 15, .seen = true, .position = {0, 0, 0.2}}));
}

TEST(MotionFilter, NoiseOfPositionsMovesATargetAtRestByNoMoreThanTheCovarianceSays) {
  const CounterRandom random(kSeed, 1000);
  uint64_t counter = 0;
  constexpr double kSigma = 0.001, kAhead = 0.08;
  const Eigen::Matrix3d noise = kSigma * kSigma * Eigen::Matrix3d::Identity();
  MotionFilter filter;
  filter.begin(Eigen::Vector3d::Zero(), noise, Eigen::Vector3d::Zero());
  double sum = 0, expected = 0;
  for (int k = 0; k < 3000; ++k) {
    Eigen::Vector3d seen;
    for (double& coordinate : seen) coordinate = kSigma * gaussian(random, counter);
    filter.predict(kPeriod, kTrackJerkNoise);
    EXPECT_TRUE(filter.correct(seen, noise));
    MotionFilter later = filter;
    later.predict(kAhead, kTrackJerkNoise);
    sum += later.position().squaredNorm();
    expected += later.covariance().topLeftCorner<3, 3>().trace();
  }
  EXPECT_LT(sum, expected) << "a target at rest has less jerk than the filter expects; seed " << kSeed;
  EXPECT_GT(sum, 0.01 * expected);
}

TEST(MotionFilter, OddTimesAndCovariancesDoNoHarm) {
  const Eigen::Vector3d there(0.4, 0.1, 0.3);
  Eigen::Matrix3d indefinite = Eigen::Matrix3d::Zero();  // by less than the rounding that a filter must allow for
  indefinite(0, 0) = 1;
  indefinite(0, 1) = indefinite(1, 0) = 3e-5;
  Eigen::Matrix3d flat = Eigen::Matrix3d::Zero();
  flat(0, 0) = 1e-6;
  const int64_t year = int64_t{365} * 86400 * 1000000;
  for (const Eigen::Matrix3d& covariance : {Eigen::Matrix3d(Eigen::Matrix3d::Zero()), flat, indefinite}) {
    TargetFilter filter({.jerk_noise_m2_s5 = kTrackJerkNoise});
    int64_t last = 0;
    for (const int64_t utime : {int64_t{0}, int64_t{0}, int64_t{1}, int64_t{33333}, int64_t{33333}, int64_t{900000},
                                int64_t{80000000}, int64_t{80000000}, year, year, year + 33333}) {
      filter.update({.utime = utime, .seen = true, .position = there, .covariance = covariance});
      last = utime;
      EXPECT_LT((filter.position_at(utime + 80000) - there).norm(), 1e-6) << utime;
    }
    filter.update({.utime = last + 33333, .seen = true, .position = {1e300, -1e300, 0}, .covariance = covariance});
    filter.update({.utime = last + 66666, .seen = true, .position = there, .covariance = covariance});
    EXPECT_LT((filter.position_at(last + 66666) - there).norm(), 1e-6);
  }
}

TEST(MotionFilter, AnObservedVelocityIsTakenAsItIs) {
  TargetFilter filter({.jerk_noise_m2_s5 = kTrackJerkNoise});
  for (int64_t k = 0; k < 30; ++k)
    filter.update({.utime = 33333 * k, .seen = true, .position = on_circle(static_cast<double>(k) / 30)});
  const Eigen::Vector3d velocity(0.1, 0, 0.2);
  filter.update({.utime = 33333 * 30, .seen = true, .position = on_circle(1), .velocity = velocity});
  EXPECT_EQ(filter.velocity_at(33333 * 30), velocity);
  filter.reset();
  EXPECT_TRUE(filter.update({.utime = 33333 * 31, .seen = true, .position = on_circle(1.5)}));
  EXPECT_EQ(filter.velocity_at(33333 * 33), Eigen::Vector3d::Zero()) << "nothing is known at first";
}

TEST(MotionFilter, OneMessageWithoutAVelocityForgetsNothing) {
  TargetFilter filter({.jerk_noise_m2_s5 = kTrackJerkNoise});
  const auto at = [](int64_t k) { return 1e-6 * static_cast<double>(33333 * k); };
  for (int64_t k = 0; k < 30; ++k)
    filter.update(
        {.utime = 33333 * k, .seen = true, .position = on_circle(at(k)), .velocity = velocity_on_circle(at(k))});
  filter.update({.utime = 33333 * 30, .seen = true, .position = on_circle(at(30))});
  // As much as the velocity changes between two images.
  EXPECT_LT((filter.velocity_at(33333 * 30) - velocity_on_circle(at(30))).norm(), 0.13 * M_PI * M_PI * 0.034);
}

}  // namespace
}  // namespace multireach::controller
