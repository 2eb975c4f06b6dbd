#include "vision/track/search_region.hpp"

#include <gtest/gtest.h>

#include "numeric/random.hpp"
#include "numeric/trigonometry.hpp"

namespace multireach::vision {
namespace {

CameraModel camera_with(const std::array<double, 8>& distortion) {
  return {.width = 640, .height = 480, .fx = 500, .fy = 510, .cx = 310, .cy = 245, .distortion = distortion};
}

/// A camera at the height of a table, that looks down on it.
Eigen::Isometry3d above_a_table() {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.linear() = rotation_from_rpy({-2.4, 0, -1.570796});
  X_WC.translation() = Eigen::Vector3d(-0.4, 0.1, 0.7);
  return X_WC;
}

TEST(SearchRegion, ThePartOfTheImageShowsEveryPointOfTheRegionThatIsInTheImage) {
  const Eigen::Isometry3d X_CW = above_a_table().inverse();
  for (const auto& distortion : {std::array<double, 8>{}, std::array<double, 8>{-0.28, 0.09, 0.0008, -0.0006}}) {
    const CameraModel camera = camera_with(distortion);
    const CounterRandom random(611);
    int in_image = 0, pixels_searched = 0;
    for (uint64_t k = 0; k < 60; ++k) {
      const auto value = [&](uint64_t i, double from, double to) { return random.uniform(1000 * k + i, from, to); };
      const Eigen::Vector3d min(value(0, -0.2, 0.4), value(1, -0.4, 0.3), value(2, -0.2, 0.2));
      const SearchRegion region(min,
                                min + Eigen::Vector3d(value(3, 0.01, 0.5), value(4, 0.01, 0.5), value(5, 0.01, 0.3)));
      const cv::Rect area = search_area(region, camera, X_CW);
      pixels_searched += area.area();
      for (uint64_t i = 0; i < 200; ++i) {
        const Eigen::Vector3d within(value(10 + 3 * i, 0, 1), value(11 + 3 * i, 0, 1), value(12 + 3 * i, 0, 1));
        const Eigen::Vector3d p_C = X_CW * (min + within.cwiseProduct(region.sizes()));
        if (p_C.z() < 0.05 || p_C.hnormalized().norm() > 0.7) continue;  // far beyond the image
        const Eigen::Vector2d px = camera.project(p_C);
        const cv::Point at(static_cast<int>(std::floor(px.x())), static_cast<int>(std::floor(px.y())));
        if (!cv::Rect(0, 0, 640, 480).contains(at)) continue;
        ++in_image;
        EXPECT_TRUE(area.contains(at)) << "region " << k << ", seed 611: " << at << " is not in " << area;
      }
    }
    EXPECT_GT(in_image, 2000);
    EXPECT_LT(pixels_searched, 60 * 640 * 480 / 2) << "regions of a few decimetres are no whole images";
  }
}

TEST(SearchRegion, OfWhatTheCameraDoesNotSeeThereIsNoPart) {
  const SearchRegion behind(Eigen::Vector3d(-2, -0.1, 0.5), Eigen::Vector3d(-1, 0.1, 0.9));
  EXPECT_TRUE(search_area(behind, camera_with({}), above_a_table().inverse()).empty());
}

TEST(SearchRegion, AroundTheCameraIsTheWholeImage) {
  const SearchRegion around(Eigen::Vector3d(-5, -5, -5), Eigen::Vector3d(5, 5, 5));
  EXPECT_EQ(search_area(around, camera_with({}), above_a_table().inverse()), cv::Rect(0, 0, 640, 480));
}

TEST(SearchRegion, APositionMayBeInsideWithinThreeStandardDeviations) {
  const SearchRegion region(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 1, 1));
  const Eigen::Matrix3d covariance = Eigen::Vector3d(1e-4, 4e-4, 9e-4).asDiagonal();
  EXPECT_TRUE(may_be_inside(region, {-0.029, 0.5, 0.5}, covariance));
  EXPECT_FALSE(may_be_inside(region, {-0.031, 0.5, 0.5}, covariance));
  EXPECT_TRUE(may_be_inside(region, {0.5, 1.059, 0.5}, covariance));
  EXPECT_FALSE(may_be_inside(region, {0.5, 1.061, 0.5}, covariance));
  EXPECT_FALSE(may_be_inside(region, {0.5, 0.5, 1.1}, covariance));
}

}  // namespace
}  // namespace multireach::vision
