#include "vision/camera_check/calibration_check.hpp"

#include <gtest/gtest.h>

#include "numeric/random.hpp"

namespace multireach::vision {
namespace {

StereoMatch match_with(double rows_px, double size_share) {
  StereoMatch match;
  match.status = StereoMatch::Status::kSeen;
  match.both_by_contour = true;
  match.epipolar_px = rows_px;
  match.epipolar_sigma_px = 0.1;
  match.size_share = size_share;
  match.size_sigma = 0.005;
  return match;
}

/// Deviations of about a standard deviation of 1: the sum of twelve uniform numbers.
double normal(const CounterRandom& random, uint64_t at) {
  double sum = -6;
  for (uint64_t k = 0; k < 12; ++k) sum += random.uniform(12 * at + k);
  return sum;
}

TEST(CalibrationCheck, SaysBySizeWhatManyMatchesShow) {
  const CounterRandom random(3);
  CalibrationCheck check;
  for (uint64_t k = 0; k < 99; ++k) {
    check.update(match_with(0.8 + 0.1 * normal(random, k), 0.03));
    EXPECT_FALSE(check.disagreement().rows_px) << k;
  }
  for (uint64_t k = 99; k < 400; ++k) check.update(match_with(0.8 + 0.1 * normal(random, k), 0.03));
  const auto off = check.disagreement();
  ASSERT_TRUE(off.rows_px && off.size_share);
  EXPECT_NEAR(*off.rows_px, 0.8, 4 * 0.1 / 17) << "four standard deviations of a mean of 300";
  EXPECT_NEAR(*off.size_share, 0.03, 1e-12);
}

TEST(CalibrationCheck, SaysNothingOfRandomErrorsOrOfFewMatchesThatAreOff) {
  const CounterRandom random(4);
  CalibrationCheck check;
  for (uint64_t k = 0; k < 1000; ++k) {
    check.update(match_with((k % 50 == 0 ? 5.0 : 0) + 0.3 * normal(random, k), 0.01 * normal(random, 1000 + k)));
    EXPECT_FALSE(check.disagreement().rows_px || check.disagreement().size_share) << k;
  }
}

TEST(CalibrationCheck, CountsOnlyContoursAndKnownRadii) {
  CalibrationCheck check;
  StereoMatch blob = match_with(3, 0.1), without_radius = match_with(0, 0.1), refused = match_with(3, 0.1);
  blob.both_by_contour = false;
  without_radius.size_sigma = 0;
  refused.status = StereoMatch::Status::kWrongRadius;
  for (int k = 0; k < 500; ++k) {
    for (const StereoMatch& match : {blob, without_radius, refused}) check.update(match);
  }
  EXPECT_FALSE(check.disagreement().rows_px || check.disagreement().size_share);
}

}  // namespace
}  // namespace multireach::vision
