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

TEST(MotionFilter, ItsCovarianceIsThatOfItsErrors) {
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
    target.velocity = normal();  // as the filter expects at first: 1 m/s, 10 m/s^2
    target.acceleration = 10 * normal();
    MotionFilter filter;
    filter.begin(target.position + factor * normal(), noise);
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
  TargetFilter filter({.jerk_noise_m2_s5 = kTrackJerkNoise}), without({});
  int64_t utime = 0;
  for (; utime < 2000000; utime += 33333) {
    const TargetObservation seen{
        .utime = utime, .seen = true, .position = on_circle(1e-6 * static_cast<double>(utime))};
    EXPECT_EQ(filter.update(seen), utime == 0);
    EXPECT_EQ(filter.position_at(utime), seen.position) << "an exact position passes unchanged";
    without.update(seen);
  }
  // The motion at the last observation; 80 ms later the target has turned by 14 degrees.
  const int64_t last = utime - 33333, later = last + 80000;
  const double t = 1e-6 * static_cast<double>(last), t_later = 1e-6 * static_cast<double>(later);
  // The jerk of the circle is 4 m/s^3; what the filter knows of acceleration, velocity and position is some 0.1 s old.
  const double jerk = 0.13 * std::pow(M_PI, 3), age = 0.1;
  EXPECT_LT((filter.velocity_at(last) - velocity_on_circle(t)).norm(), jerk * age * age);
  EXPECT_LT((filter.position_at(later) - on_circle(t_later)).norm(), jerk * std::pow(age + 0.08, 3));
  EXPECT_GT((without.position_at(later) - on_circle(t_later)).norm(), 0.03) << "by positions alone it lags";
}

TEST(MotionFilter, NoiseOfPositionsHardlyMovesATargetAtRest) {
  const CounterRandom random(kSeed, 1000);
  uint64_t counter = 0;
  constexpr double kSigma = 0.001;
  const Eigen::Vector3d there(0.4, 0.1, 0.3);
  TargetFilter filter({.jerk_noise_m2_s5 = kTrackJerkNoise});
  double sum = 0;
  int number = 0;
  for (int64_t k = 0; k < 3000; ++k) {
    Eigen::Vector3d seen = there;
    for (double& coordinate : seen) coordinate += kSigma * gaussian(random, counter);
    filter.update({.utime = 33333 * k,
                   .seen = true,
                   .position = seen,
                   .covariance = kSigma * kSigma * Eigen::Matrix3d::Identity()});
    if (k < 100) continue;
    sum += (filter.position_at(33333 * k + 30000) - there).squaredNorm();
    ++number;
  }
  EXPECT_LT(std::sqrt(sum / number / 3), 3 * kSigma) << "30 ms ahead";
  TargetFilter exact({.jerk_noise_m2_s5 = kTrackJerkNoise});
  for (int64_t k = 0; k < 100; ++k) exact.update({.utime = 33333 * k, .seen = true, .position = there});
  EXPECT_EQ(exact.position_at(33333 * 99 + 30000), there);
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

}  // namespace
}  // namespace multireach::controller
