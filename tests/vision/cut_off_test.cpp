// Objects that the border of the image cuts off.
#include <gtest/gtest.h>

#include <array>
#include <numbers>

#include "tests/vision/ball_picture.hpp"
#include "vision/contour/blob_centroid.hpp"
#include "vision/contour/sphere_contour.hpp"
#include "vision/stereo/triangulate.hpp"

namespace multireach::vision {
namespace {

using Kind = SphereContour::Kind;

constexpr int kWide = 200, kHigh = 150;
const cv::Rect kImage(0, 0, kWide, kHigh);

/// The centroid of an ellipse, relative to pixel (0, 0).
BlobCentroid ellipse(const Eigen::Vector2d& centre, double half_width, double half_height) {
  std::vector<BlobExtent> rows;
  cv::Rect box;
  for (int y = 0; y < kHigh; ++y) {
    const double across = (y - centre.y()) / half_height;
    if (std::abs(across) >= 1) continue;
    const double half = half_width * std::sqrt(1 - across * across);
    const int begin = std::max(0, static_cast<int>(std::ceil(centre.x() - half)));
    const int end = std::min(kWide, static_cast<int>(std::floor(centre.x() + half)) + 1);
    if (end <= begin) continue;
    const cv::Rect row(begin, y, end - begin, 1);
    box = rows.empty() ? row : box | row;
    rows.push_back({begin, end});
  }
  return centroid_of(rows, box, kImage, {0, 0});
}

TEST(BlobCentroid, WhatIsWholeIsAtItsCentroid) {
  const BlobCentroid whole = ellipse({80, 70}, 30, 20);
  EXPECT_FALSE(whole.cut_off);
  EXPECT_EQ(whole.cut_off_share, 0);
  EXPECT_NEAR((whole.centre - Eigen::Vector2d(80, 70)).norm(), 0, 1e-6);
  EXPECT_TRUE(whole.from_aspect.isZero());
}

TEST(BlobCentroid, ADiscThatTheBorderCutsOffIsCompleted) {
  constexpr double kRadius = 25, kPixel = 1;
  for (const double inside : {24.0, 16.0, 8.0}) {  // pixels from the centre to the border
    const Eigen::Vector2d middle(kWide / 2, kHigh / 2), last(kWide - 1 - inside, kHigh - 1 - inside);
    for (const Eigen::Vector2d& centre : {Eigen::Vector2d(inside, middle.y()), Eigen::Vector2d(last.x(), middle.y()),
                                          Eigen::Vector2d(middle.x(), inside), Eigen::Vector2d(middle.x(), last.y())}) {
      const BlobCentroid disc = ellipse(centre, kRadius, kRadius);
      EXPECT_TRUE(disc.cut_off);
      EXPECT_LE((disc.centre - centre).norm(), kPixel + 1e-9) << centre.transpose();
      EXPECT_NEAR(disc.radius_px, kRadius, kPixel);
      const double d = inside / kRadius, segment = (std::acos(d) - d * std::sqrt(1 - d * d)) / std::numbers::pi;
      const double per_pixel = 2 * std::sqrt(1 - d * d) / (std::numbers::pi * kRadius);
      EXPECT_NEAR(disc.cut_off_share, segment, 2 * kPixel * per_pixel + 0.002);
    }
  }
}

// Bottles, boxes and hats: sides as 2 to 3 and as 3 to 2, of which the border hides up to 30 of 100 parts of the width.
TEST(BlobCentroid, WhatIsNotRoundIsWhereItsCovarianceSays) {
  constexpr double kHalf = 24;
  for (const double aspect : {2.0 / 3, 1.0, 3.0 / 2}) {
    for (const double beyond : {0.05, 0.15, 0.3}) {
      const Eigen::Vector2d centre(kHalf * aspect * (1 - 2 * beyond), 70);
      const BlobCentroid object = ellipse(centre, kHalf * aspect, kHalf);
      ASSERT_TRUE(object.cut_off);
      const Eigen::Vector2d error = object.centre - centre;
      EXPECT_LT(error.dot(object.covariance.inverse() * error), 9.21) << "99 %: " << aspect << ", " << beyond;
      EXPECT_LT(object.centre.x() - object.radius_px, 0.5) << "the rest is beyond the border";
    }
  }
}

TEST(BlobCentroid, InACornerOrMoreThanHalfBeyondTheBorderItIsNotLocated) {
  EXPECT_EQ(ellipse({15, 15}, 20, 20).cut_off_share, 1);
  EXPECT_EQ(ellipse({-4, 70}, 20, 20).cut_off_share, 1);
  EXPECT_EQ(ellipse({100, 75}, 300, 20).cut_off_share, 1) << "from border to border";
}

TEST(SphereContourFit, AtTheBorderItFitsWhatIsThere) {
  const CameraModel c = camera();
  const Eigen::Vector3d p(0.03 * 0.4 + 0.4 * (c.width - 1 - c.cx) / c.fx - 0.025, 0, 0.4);
  const cv::Mat image = picture(c, p, 0.03, {.noise = 2});
  const SphereContour disc = SphereContourFitter(c).fit(image, red_blobs(image).at(0));
  EXPECT_TRUE(disc.cut_off);
  const Eigen::Vector2d error = disc.ray() - p.hnormalized();
  EXPECT_LT(error.dot(disc.ray_covariance().inverse() * error), 14);
}

// Half of a contour locates a ball, also where it is not known to be one: the border explains what is missing.
TEST(SphereContourFit, ABallThatTheBorderCutsOffIsWhereItsCovarianceSays) {
  const CameraModel c = camera();
  const CounterRandom random(17);
  const Eigen::Vector3d light = Eigen::Vector3d(-1, -2, -1.5).normalized();
  constexpr double kRadius = 0.03;
  constexpr int kPictures = 80;
  int by_contour = 0, inside = 0;
  double nees = 0;
  for (int k = 0; k < kPictures; ++k) {
    const auto uniform = [&](int which, double from, double to) {
      return random.uniform(static_cast<uint64_t>(3 * k + which), from, to);
    };
    const double z = uniform(0, 0.35, 0.5), radius_px = c.fx * kRadius / z;
    const double from_border = uniform(1, 0.2, 0.95) * radius_px, along = uniform(2, -50, 50);
    const std::array<Eigen::Vector2d, 4> centres{{{from_border, 120 + along},
                                                  {c.width - 1 - from_border, 120 + along},
                                                  {160 + along, from_border},
                                                  {160 + along, c.height - 1 - from_border}}};
    const Eigen::Vector3d p = z * c.ray(centres[static_cast<size_t>(k % 4)]).homogeneous();
    const double wall = k % 3 == 0 ? 30 : k % 3 == 1 ? 100 : 190;
    const cv::Mat image = picture(c, p, kRadius, {.wall_rgb = {wall, wall + 5, wall + 10}, .noise = 3, .light = light});
    const SphereContour ball =
        SphereContourFitter(c, SphereContourFitter::kOfAnything).fit(image, red_blobs(image).at(0));
    EXPECT_TRUE(ball.cut_off);
    by_contour += ball.kind == Kind::kEdges;
    const Eigen::Vector2d error = ball.ray() - p.hnormalized();
    const double squared = error.dot(ball.ray_covariance().inverse() * error);
    nees += squared / 2;
    inside += squared < 5.991;  // 95 % of chi^2 with two degrees of freedom
  }
  EXPECT_GE(by_contour, 0.9 * kPictures);
  EXPECT_LT(nees / kPictures, 1.25);
  // Where 95 % are inside on average, 99 % of such samples have at least 88.75 % inside (71 of 80).
  EXPECT_GE(inside, 0.8875 * kPictures);
}

}  // namespace
}  // namespace multireach::vision
