// What docs/results.md says of a motion: against motions whose quantities are known.
#include "tools/figures/motion.hpp"

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
