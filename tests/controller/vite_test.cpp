#include "controller/law/vite.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace multireach::controller {
namespace {

/// The largest position of an attractor that starts at rest at 0 with its target at 1.
double peak(const ViteGains& gains) {
  double r = 0, v = 0, highest = 0;
  for (int k = 0; k < 2000; ++k) {
    v = vite_velocity(gains, r, v, 1.0);
    r += v;
    highest = std::max(highest, r);
  }
  EXPECT_NEAR(r, 1, 1e-9);
  return highest;
}

TEST(Vite, OvershootsWithThePapersGainsByAboutOnePercent) {
  // Damping ratio sqrt(alpha / (4 beta)) = 0.816: exp(-pi z / sqrt(1 - z^2)) = 1.2 % in continuous time.
  const double z = std::sqrt(0.08 / (4 * 0.03));
  const double expected = std::exp(-M_PI * z / std::sqrt(1 - z * z));
  EXPECT_NEAR(expected, 0.012, 0.0005);
  EXPECT_NEAR(peak({0.08, 0.03}) - 1, expected, 0.004);
}

TEST(Vite, DoesNotOvershootWhenAlphaIsFourBetaOrMore) {
  EXPECT_LE(peak({0.08, 0.02}), 1 + 1e-12);
  EXPECT_LE(peak({0.2, 0.03}), 1 + 1e-12);
  EXPECT_GT(peak({0.08, 0.025}), 1 + 1e-6) << "the check can fail";
}

TEST(Vite, FollowsTheClosedFormOfTheRecurrence) {
  // The recurrence is r_{k+1} - 1 = (2 - a - a b) (r_k - 1) - (1 - a) (r_{k-1} - 1); its roots are known.
  const ViteGains gains{0.1, 0.01};
  const double a = gains.alpha, b = gains.beta, p = 2 - a - a * b, q = 1 - a;
  const double root = std::sqrt(p * p / 4 - q), s1 = p / 2 + root, s2 = p / 2 - root;
  // The initial values are r_0 = 0 and r_1 = a b.
  const double c1 = (a * b - 1 + s2) / (s1 - s2), c2 = -1 - c1;
  double r = 0, v = 0;
  for (int k = 1; k <= 300; ++k) {
    v = vite_velocity(gains, r, v, 1.0);
    r += v;
    ASSERT_NEAR(r, 1 + c1 * std::pow(s1, k) + c2 * std::pow(s2, k), 1e-12) << k;
  }
}

}  // namespace
}  // namespace multireach::controller
