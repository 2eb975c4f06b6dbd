// Gains in time against the closed form of the differential equation that they stand for.
#include "controller/law/attractor_gains.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "controller/tracking_defaults.hpp"

namespace multireach::controller {
namespace {

constexpr std::array<double, 5> kRates{60, 100, 140, 500, 1000};

/// The error of r'' = w^2 (r_T - r) - 2 z w r' at `time`, from rest at the distance 1.
double error_at(const AttractorMotion& motion, double time) {
  const double w = motion.natural_frequency, z = motion.damping_ratio;
  if (z == 1) return (1 + w * time) * std::exp(-w * time);
  const double root = std::sqrt(z * z - 1), slow = w * (z - root), fast = w * (z + root);
  return (fast * std::exp(-slow * time) - slow * std::exp(-fast * time)) / (fast - slow);
}

TEST(AttractorGains, AttractorMovesAsTheDifferentialEquationSays) {
  for (const AttractorMotion& motion : {AttractorMotion{5.7, 1}, AttractorMotion{3, 1.5}, AttractorMotion{28, 1.26}}) {
    for (const double rate : kRates) {
      const ViteGains gains = vite_gains(motion, rate);
      double r = 0, v = 0;
      for (int step = 1; step <= 3 * rate; ++step) {
        v = vite_velocity(gains.alpha, gains.beta, r, v, 1.0);
        r += v;
        // The velocity of a step holds from its beginning to its end, so the motion leads by half a step.
        const double curvature = std::pow(motion.natural_frequency * motion.damping_ratio / rate, 2);
        ASSERT_NEAR(1 - r, error_at(motion, (step + 0.5) / rate), curvature) << rate << " " << step;
        ASSERT_LE(r, 1 + 1e-12);
      }
    }
  }
}

TEST(AttractorGains, MotionAndGainsAreInverse) {
  for (const AttractorMotion& motion :
       {AttractorMotion{5.7, 1.001}, AttractorMotion{0.01, 3}, AttractorMotion{80, 1.2}}) {
    for (const double rate : kRates) {
      const AttractorMotion again = attractor_motion(vite_gains(motion, rate), rate);
      EXPECT_NEAR(again.natural_frequency / motion.natural_frequency, 1, 1e-8);
      EXPECT_NEAR(again.damping_ratio / motion.damping_ratio, 1, 1e-8);
      const ViteGains here = vite_gains(motion, rate), there = gains_at_rate(vite_gains(motion, 140), 140, rate);
      EXPECT_NEAR(there.alpha / here.alpha, 1, 1e-8);
      EXPECT_NEAR(there.beta / here.beta, 1, 1e-8);
    }
  }
}

TEST(AttractorGains, AreUnchangedAtTheRateForWhichTheyAreGiven) {
  for (const ViteGains& gains : {ViteGains{0.08, 0.02}, kTrackGains}) {
    const ViteGains same = gains_at_rate(gains, kReferenceRate, 140);
    EXPECT_EQ(same.alpha, gains.alpha);
    EXPECT_EQ(same.beta, gains.beta);
  }
}

TEST(AttractorGains, DefaultsAreWhatTheDocumentationSays) {
  const AttractorMotion reach = attractor_motion({0.08, 0.02}, 140), track = attractor_motion(kTrackGains, 140);
  EXPECT_NEAR(reach.natural_frequency, 5.72, 0.005);
  EXPECT_NEAR(reach.damping_ratio, 1.02, 0.005);
  EXPECT_NEAR(track.natural_frequency, 28.35, 0.05);
  EXPECT_NEAR(track.damping_ratio, 1.26, 0.005);
}

}  // namespace
}  // namespace multireach::controller
