// How multireach-bench-real counts answers to labels in both images of a pair.
#include "bench/real/stereo_score.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>

namespace multireach::bench {
namespace {

/// Two metres before the cameras, an error of a pixel of disparity is 2 * 2 / (500 * 0.1) = 0.08 m.
StereoRig rig() {
  return parallel_rig(640, 480, 500, 0.1);
}

const StereoPoint kLabel{{320, 240}, {295, 240}};  // 500 px * 0.1 m / 25 px: 2 m

TEST(StereoScore, TheLabelsPositionIsTheirTriangulation) {
  const auto truth = position_of_labels(rig(), kLabel);
  ASSERT_TRUE(truth);
  const Eigen::Vector3d p_L = rig().X_WL.inverse() * truth->p_W;
  const CameraModel& left = rig().left;
  EXPECT_NEAR(p_L.z(), 2, 1e-9);
  EXPECT_NEAR(p_L.x(), 2 * (320 - left.cx) / 500, 1e-9);
  // Half a pixel in each image: 0.08 m per pixel of disparity.
  const Eigen::Vector3d along = rig().X_WL.linear() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(std::sqrt(along.dot(truth->covariance * along)), 0.08 * 0.5 * std::sqrt(2), 1e-3);
  // Rays that miss each other by 6 px, 6 / (0.5 sqrt 2) sigmas.
  const auto apart = position_of_labels(rig(), {kLabel.left, {295, 246}});
  ASSERT_TRUE(apart);
  EXPECT_NEAR(apart->covariance(2, 2) / truth->covariance(2, 2), 72, 2);
  EXPECT_FALSE(position_of_labels(rig(), {kLabel.left, {345, 240}})) << "behind the cameras";
}

TEST(StereoScore, CountsByPixelsInBothImagesAndBySigmas) {
  const auto truth = position_of_labels(rig(), kLabel);
  ASSERT_TRUE(truth);
  const Eigen::Matrix3d covariance = 3 * truth->covariance;  // with that of the label: four times the label's
  const Eigen::Vector3d along = rig().X_WL.linear() * Eigen::Vector3d::UnitZ();
  // An error e along the ray is e / sigma_m standard deviations of the label's covariance.
  const double sigma_m = 1 / std::sqrt(along.dot(truth->covariance.inverse() * along));
  StereoScore score;
  score.labelled = 4;
  const auto add = [&](double left_px, double right_px, double depth_m) {
    StereoAnswer answer{kLabel, truth->p_W + depth_m * along, covariance};
    answer.px.left.x += left_px;
    answer.px.right.y += right_px;
    score.add(answer, kLabel, *truth);
  };
  add(10, 0, 0);
  add(0, 11, 2 * sigma_m);
  add(0, 26, 8 * sigma_m);
  EXPECT_EQ(score.right_percent(), 25);
  EXPECT_EQ(score.wrong_percent(), 25);
  ASSERT_EQ(score.squared_sigmas.size(), 3U);
  EXPECT_NEAR(score.squared_sigmas[1], 1, 1e-9);
  EXPECT_NEAR(score.squared_sigmas[2], 16, 1e-9);
  EXPECT_NEAR(score.errors_mm[2], 8000 * sigma_m, 1e-6);
  EXPECT_EQ(score.covariance_cells().substr(0, 4), "1.89") << "(0 + 1 + 16) / 3 / 3";
  EXPECT_NE(score.covariance_cells().find("66.7 %"), std::string::npos);
  StereoScore sum = score;
  sum.add(score);
  EXPECT_EQ(sum.right_percent(), 25);
  EXPECT_EQ(sum.errors_mm.size(), 6U);
  // An answer without a position or covariance counts by its pixels only.
  score.add({kLabel, std::nullopt, std::nullopt}, kLabel, *truth);
  EXPECT_EQ(score.right, 2);
  EXPECT_EQ(score.errors_mm.size(), 3U);
}

}  // namespace
}  // namespace multireach::bench
