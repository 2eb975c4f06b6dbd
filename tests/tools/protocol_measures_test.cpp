#include "tools/figures/protocol_measures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace multireach {
namespace {

constexpr double kTick = 0.001;

/// A straight minimum-jerk movement of one second by 0.2 m, and a second of rest.
std::vector<Eigen::Vector3d> minimum_jerk(double pause_at = 2) {
  std::vector<Eigen::Vector3d> hand;
  double t = 0;
  int paused = 0;
  for (int k = 0; k <= 2000; ++k) {
    hand.emplace_back(0.2 * t * t * t * (10 - 15 * t + 6 * t * t), 0, 0);
    if (t >= pause_at && paused++ < 100) continue;
    t = std::min(1.0, t + kTick);
  }
  return hand;
}

TEST(ProtocolMeasures, AMinimumJerkMovementHasTheJerkOfTheClosedForm) {
  const ReachMeasures reach = measure_reach(minimum_jerk(), Eigen::Vector3d(0.2, 0, 0), kTick);
  EXPECT_NEAR(reach.error_m, 0, 1e-12);
  EXPECT_NEAR(reach.path_ratio, 1, 1e-9);
  EXPECT_EQ(reach.speed_peaks, 1);
  // It has 1 % left at T with 10 s^3 - 15 s^4 + 6 s^5 = 0.01 for s = 1 - T. The jerk is 60 - 360 t + 360 t^2.
  double s = 0.1;
  for (int k = 0; k < 50; ++k) s = std::cbrt(0.01 / (10 - 15 * s + 6 * s * s));
  const double T = 1 - s;
  EXPECT_NEAR(reach.settled_s, T, 2 * kTick);
  double integral = 0;
  constexpr int kParts = 100000;
  for (int k = 0; k < kParts; ++k) {
    const double t = T * (k + 0.5) / kParts, jerk = 60 - 360 * t + 360 * t * t;
    integral += jerk * jerk * T / kParts;
  }
  EXPECT_NEAR(reach.normalised_jerk, std::sqrt(0.5 * integral * std::pow(T, 5)) / 0.99, 0.1);
}

TEST(ProtocolMeasures, AMovementThatPausesIsLessSmooth) {
  const auto smooth = measure_reach(minimum_jerk(), Eigen::Vector3d(0.2, 0, 0), kTick);
  const auto halting = measure_reach(minimum_jerk(0.5), Eigen::Vector3d(0.2, 0, 0), kTick);
  EXPECT_EQ(halting.speed_peaks, 2);
  EXPECT_GT(halting.normalised_jerk, 10 * smooth.normalised_jerk);
}

TEST(ProtocolMeasures, AReachThatDoesNotArriveNeverSettles) {
  const ReachMeasures reach = measure_reach(minimum_jerk(), Eigen::Vector3d(0.3, 0, 0), kTick);
  EXPECT_NEAR(reach.error_m, 0.1, 1e-12);
  EXPECT_NEAR(reach.settled_s, 2, 1e-12);
}

TEST(ProtocolMeasures, PeaksThatDoNotStandOutAreNotCounted) {
  EXPECT_EQ(count_peaks(std::vector<double>{}, 0.05), 0);
  EXPECT_EQ(count_peaks(std::vector<double>{0, 0, 0}, 0.05), 0);
  EXPECT_EQ(count_peaks(std::vector<double>{0, 1, 0.98, 1, 0}, 0.05), 1);
  EXPECT_EQ(count_peaks(std::vector<double>{0, 1, 0.9, 1, 0}, 0.05), 2);
  EXPECT_EQ(count_peaks(std::vector<double>{1, 0, 0.03, 0, 0.5}, 0.05), 2);
}

TEST(ProtocolMeasures, TheJerkOfASineIsItsThirdDerivative) {
  std::vector<JointVector> theta;
  const double rate = 3;
  for (int k = 0; k <= 10000; ++k) {
    JointVector posture(2);
    posture << std::sin(rate * k * kTick * 2 * std::numbers::pi / 10), 1;
    theta.push_back(posture);
  }
  const double omega = rate * 2 * std::numbers::pi / 10;
  EXPECT_NEAR(rms_jerk(std::span<const JointVector>(theta), kTick), std::pow(omega, 3) / std::sqrt(2), 1e-3);
}

}  // namespace
}  // namespace multireach
