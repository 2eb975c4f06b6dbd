// What the results in docs/ say of a motion: against motions whose quantities are known.
#include "studies/figures/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace multireach {
namespace {

/// A hand on the line x = position(t), sampled every 10 ms for `seconds`; one joint that moves with it.
template <class Position, class Speed>
Motion on_a_line(double seconds, Position&& position, Speed&& speed) {
  Motion motion;
  for (int k = 0; k <= static_cast<int>(std::lround(100 * seconds)); ++k) {
    const double t = 0.01 * k;
    motion.push_back({.time = t,
                      .theta = JointVector::Constant(1, position(t)),
                      .velocity = JointVector::Constant(1, speed(t)),
                      .theta_target = {},
                      .x = {position(t), 0, 0},
                      .x_dot = {speed(t), 0, 0}});
  }
  return motion;
}

const auto kSmooth = [](double t) { return 0.5 * (1 - std::cos(std::numbers::pi * t)); };
const auto kBell = [](double t) { return 0.5 * std::numbers::pi * std::sin(std::numbers::pi * t); };

TEST(Motion, AStraightBell) {
  const Motion motion = on_a_line(1, kSmooth, kBell);
  EXPECT_NEAR(straightness(motion), 1, 1e-12);
  EXPECT_NEAR(bulge(motion), 0, 1e-12);
  EXPECT_EQ(speed_peaks(motion), 1);
  EXPECT_NEAR(speed_peak(motion).speed, 0.5 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(speed_peak(motion).time, 0.5, 1e-12);
  EXPECT_NEAR(largest_velocity_step(motion), 0.5 * std::numbers::pi * std::sin(0.01 * std::numbers::pi), 1e-12);
  EXPECT_NEAR(settled_after(motion, {1, 0, 0}, 0.5), 0.5, 0.011);
  EXPECT_TRUE(std::isnan(settled_after(motion, {2, 0, 0}, 0.5)));
}

TEST(Motion, TwoMaximaAreTwoOnlyWhenTheSpeedFallsBetweenThem) {
  const auto with_dip = [](double depth) {
    return on_a_line(1, kSmooth, [&](double t) { return kBell(t) - depth * std::exp(-std::pow((t - 0.5) / 0.05, 2)); });
  };
  EXPECT_EQ(speed_peaks(with_dip(0.5)), 2);
  EXPECT_EQ(speed_peaks(with_dip(0.01)), 1);
}

TEST(Motion, AHalfCircle) {
  Motion motion;
  for (int k = 0; k <= 1000; ++k) {
    const double angle = std::numbers::pi * k / 1000;
    motion.push_back({.time = 0.001 * k,
                      .theta = JointVector::Zero(1),
                      .velocity = JointVector::Zero(1),
                      .theta_target = {},
                      .x = {-std::cos(angle), std::sin(angle), 0},
                      .x_dot = {0, 0, 0}});
  }
  EXPECT_NEAR(straightness(motion), std::numbers::pi / 2, 1e-5);
  EXPECT_NEAR(bulge(motion), 0.5, 1e-5);
}

TEST(Motion, TheDelayOfTheSecondIsFoundAndTheRestIsMeasured) {
  const Motion wanted = on_a_line(2, kSmooth, kBell);
  const Motion late = on_a_line(
      2, [](double t) { return t < 0.03 ? 0 : kSmooth(t - 0.03); }, kBell);
  EXPECT_NEAR(difference(wanted, late).delay_s, 0.03, 1e-12);
  EXPECT_LT(difference(wanted, late).largest_m, 1e-9);
  Motion beside = late;
  for (Moment& moment : beside) moment.x.y() += 0.002;
  EXPECT_NEAR(difference(wanted, beside).rms_m, 0.002, 1e-9);
  EXPECT_NEAR(difference(wanted, beside).largest_m, 0.002, 1e-9);
}

TEST(Motion, AveragingTakesStepsOut) {
  // Steps of 50 ms around a constant speed of 1.
  const auto speed = [](double t) { return std::fmod(t, 0.1) < 0.05 ? 1.5 : 0.5; };
  const Motion stepped = on_a_line(
      1, [](double t) { return t; }, speed);
  EXPECT_GT(speed_peaks(stepped), 5);
  EXPECT_NEAR(moment_at(averaged(stepped, 0.05), 0.5).x_dot.x(), 1, 1e-9);
}

/// A straight minimum-jerk movement of one second by 0.2 m, paused for 0.1 s at `pause_at`, and rest until 2 s.
Motion minimum_jerk(double pause_at = 2) {
  constexpr double kTick = 0.001;
  Motion motion;
  double t = 0;
  int paused = 0;
  for (int k = 0; k <= 2000; ++k) {
    const Eigen::Vector3d position(0.2 * t * t * t * (10 - 15 * t + 6 * t * t), 0, 0);
    append_setpoint(motion, kTick, JointVector::Constant(1, position.x()), position);
    if (t >= pause_at && paused++ < 100) continue;
    t = std::min(1.0, t + kTick);
  }
  return motion;
}

TEST(Motion, AMinimumJerkMovementHasTheJerkOfTheClosedForm) {
  const Motion motion = minimum_jerk();
  EXPECT_NEAR(motion.back().x.x(), 0.2, 1e-12);
  EXPECT_NEAR(straightness(motion), 1, 1e-9);
  EXPECT_EQ(speed_peaks(motion), 1);
  // It has 1 % left at T with 10 s^3 - 15 s^4 + 6 s^5 = 0.01 for s = 1 - T. The jerk is 60 - 360 t + 360 t^2.
  double s = 0.1;
  for (int k = 0; k < 50; ++k) s = std::cbrt(0.01 / (10 - 15 * s + 6 * s * s));
  const double T = 1 - s, settled = settled_after(motion, {0.2, 0, 0}, 0.002);
  EXPECT_NEAR(settled, T, 0.002);
  double integral = 0;
  constexpr int kParts = 100000;
  for (int k = 0; k < kParts; ++k) {
    const double t = T * (k + 0.5) / kParts, jerk = 60 - 360 * t + 360 * t * t;
    integral += jerk * jerk * T / kParts;
  }
  EXPECT_NEAR(normalised_jerk(part(motion, 0, settled)), std::sqrt(0.5 * integral * std::pow(T, 5)) / 0.99, 0.1);
}

TEST(Motion, AMovementThatPausesIsLessSmooth) {
  const Motion smooth = minimum_jerk(), halting = minimum_jerk(0.5);
  EXPECT_EQ(speed_peaks(halting), 2);
  const auto until_arrival = [](const Motion& motion) {
    return normalised_jerk(part(motion, 0, settled_after(motion, {0.2, 0, 0}, 0.002)));
  };
  EXPECT_GT(until_arrival(halting), 10 * until_arrival(smooth));
}

TEST(Motion, AReachThatDoesNotArriveNeverSettles) {
  EXPECT_TRUE(std::isnan(settled_after(minimum_jerk(), {0.3, 0, 0}, 0.003)));
}

TEST(Motion, PeaksThatDoNotStandOutAreNotCounted) {
  EXPECT_EQ(count_peaks(std::vector<double>{}, 0.05), 0);
  EXPECT_EQ(count_peaks(std::vector<double>{0, 0, 0}, 0.05), 0);
  EXPECT_EQ(count_peaks(std::vector<double>{0, 1, 0.98, 1, 0}, 0.05), 1);
  EXPECT_EQ(count_peaks(std::vector<double>{0, 1, 0.9, 1, 0}, 0.05), 2);
  EXPECT_EQ(count_peaks(std::vector<double>{1, 0, 0.03, 0, 0.5}, 0.05), 2);
}

TEST(Motion, TheJerkOfASineIsItsThirdDerivative) {
  Motion motion;
  const double tick = 0.001, omega = 0.6 * std::numbers::pi;
  for (int k = 0; k <= 10000; ++k) {
    JointVector posture(2);
    posture << std::sin(omega * k * tick), 1;
    append_setpoint(motion, tick, posture, {0, 2 * posture[0], 1});
  }
  EXPECT_NEAR(joint_jerk(motion), std::pow(omega, 3) / std::sqrt(2), 1e-3);
  EXPECT_NEAR(hand_jerk(motion), 2 * joint_jerk(motion), 1e-9);
}

TEST(Motion, SetpointsHaveTheVelocitiesThatLeadToThem) {
  const Motion motion = minimum_jerk();
  EXPECT_EQ(motion.front().x_dot.norm(), 0);
  EXPECT_NEAR(motion[500].time, 0.5, 1e-12);
  EXPECT_NEAR(motion[500].x_dot.x(), 0.2 * 1.875, 1e-4);
  EXPECT_NEAR(motion[500].velocity[0], motion[500].x_dot.x(), 1e-12);
}

TEST(Motion, APartHasItsFirstAndLastMoment) {
  const Motion middle = part(minimum_jerk(), 0.1, 0.3);
  EXPECT_EQ(middle.size(), 201);
  EXPECT_NEAR(middle.front().time, 0.1, 1e-12);
  EXPECT_NEAR(middle.back().time, 0.3, 1e-12);
  EXPECT_TRUE(part(middle, 0.4, 0.5).empty());
}

TEST(Motion, BetweenAndBeyondItsMoments) {
  const Motion motion = on_a_line(
      1, [](double t) { return t; }, [](double) { return 1.0; });
  EXPECT_NEAR(moment_at(motion, 0.123).x.x(), 0.123, 1e-12);
  EXPECT_EQ(moment_at(motion, -1).x.x(), 0);
  EXPECT_EQ(moment_at(motion, 9).x.x(), motion.back().x.x());
}

TEST(Measures, AreWrittenOneARow) {
  EXPECT_EQ(measures_csv("fig1", {{"paper", "speed", 0.25, "m/s"}, {"guarded", "peaks", 1, ""}}),
            "figure,law,quantity,value,unit\nfig1,paper,speed,0.25,m/s\nfig1,guarded,peaks,1,\n");
}

}  // namespace
}  // namespace multireach
