// Objects that the border of the image cuts off.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/vision/ball_picture.hpp"
#include "vision/contour/blob_centre.hpp"
#include "vision/contour/sphere_contour.hpp"

namespace multireach::vision {
namespace {

using Kind = SphereContour::Kind;

constexpr int kWide = 200, kHigh = 150;
const cv::Rect kImage(0, 0, kWide, kHigh);
constexpr double kMany = 9.21;  // 99 % of chi^2 with two degrees of freedom

/// The pixels of an image for which `inside` holds.
template <class Inside>
BlobCentre centre_of_pixels(const Inside& inside) {
  std::vector<BlobExtent> rows;
  cv::Rect box;
  for (int y = 0; y < kHigh; ++y) {
    int begin = kWide, end = 0;
    for (int x = 0; x < kWide; ++x) {
      if (!inside(Eigen::Vector2d(x, y))) continue;
      begin = std::min(begin, x);
      end = x + 1;
    }
    if (end <= begin) continue;
    const cv::Rect row(begin, y, end - begin, 1);
    box = rows.empty() ? row : box | row;
    rows.push_back({begin, end});
  }
  return centre_of(rows, box, kImage, {0, 0});
}

/// |x / a|^n + |y / b|^n < 1, turned by an angle: n is 1 for a diamond, 2 for an ellipse, large for a box.
struct Shape {
  double a, b, n = 2, angle = 0;

  BlobCentre at(const Eigen::Vector2d& centre) const {
    const Eigen::Rotation2Dd R(-angle);
    return centre_of_pixels([&](const Eigen::Vector2d& pixel) {
      const Eigen::Vector2d p = R * (pixel - centre);
      return std::pow(std::abs(p.x() / a), n) + std::pow(std::abs(p.y() / b), n) < 1;
    });
  }
  /// How far it reaches along x from its centre.
  double reach() const { return n == 2 ? std::hypot(a * std::cos(angle), b * std::sin(angle)) : a; }
};

double squared_sigmas(const BlobCentre& found, const Eigen::Vector2d& centre) {
  const Eigen::Vector2d error = found.px - centre;
  return error.dot(found.covariance.inverse() * error);
}

TEST(BlobCentre, OfAWholeObjectIsItsCentroid) {
  const BlobCentre whole = Shape{30, 20}.at({80, 70});
  EXPECT_FALSE(whole.cut_off);
  EXPECT_EQ(whole.cut_off_share, 0);
  EXPECT_NEAR((whole.px - Eigen::Vector2d(80, 70)).norm(), 0, 1e-6);
  EXPECT_TRUE(whole.shape_sigma.isZero());
}

TEST(BlobCentre, OfADiscThatTheBorderCutsOffIsWhereTheDiscIs) {
  constexpr double kRadius = 25, kTenth = 0.1;     // of the half axes, as of a whole blob
  for (const double inside : {24.0, 16.0, 8.0}) {  // pixels from the centre to the border
    const Eigen::Vector2d middle(kWide / 2, kHigh / 2), last(kWide - 1 - inside, kHigh - 1 - inside);
    for (const Eigen::Vector2d& centre : {Eigen::Vector2d(inside, middle.y()), Eigen::Vector2d(last.x(), middle.y()),
                                          Eigen::Vector2d(middle.x(), inside), Eigen::Vector2d(middle.x(), last.y())}) {
      const BlobCentre disc = Shape{kRadius, kRadius}.at(centre);
      EXPECT_TRUE(disc.cut_off);
      EXPECT_LT((disc.px - centre).norm(), kTenth * kRadius) << centre.transpose();
      EXPECT_NEAR(disc.radius_px, kRadius, kTenth * kRadius);
      // A chord is right to a pixel and a half, and the border is half a pixel away.
      const double d = inside / kRadius, q = std::sqrt(1 - d * d), per_distance = 2 * q / std::numbers::pi;
      const double segment = (std::acos(d) - d * q) / std::numbers::pi;
      EXPECT_NEAR(disc.cut_off_share, segment, per_distance * (q / d * 1.5 / (2 * kRadius) + 1 / kRadius));
    }
  }
}

// From all ellipses: bottles and eggs, turned in any direction.
TEST(BlobCentre, OfAnEllipseThatTheBorderCutsOffIsWhereTheEllipseIs) {
  constexpr double kHalf = 22, kTenth = 0.1, kQuarterTurn = 1.5707963267948966;
  for (const double aspect : {0.5, 0.8, 1.25, 2.0}) {
    for (const double angle : {0.0, 0.4, 0.9, kQuarterTurn}) {
      for (const double inside : {0.4, 0.6, 0.8}) {  // of the reach along x
        const Shape ellipse{kHalf * aspect, kHalf, 2, angle};
        const Eigen::Vector2d centre(inside * ellipse.reach(), 75);
        const BlobCentre found = ellipse.at(centre);
        if (found.cut_off_share < BlobCentre::kNotLocated) {
          EXPECT_LT((found.px - centre).norm(), kTenth * std::max(ellipse.a, ellipse.b))
              << aspect << ", " << angle << ", " << inside;
        }
        EXPECT_LT(squared_sigmas(found, centre), kMany);
      }
    }
  }
}

TEST(BlobCentre, OfAnotherShapeIsWhereItsCovarianceSaysOrNotLocated) {
  constexpr double kHalf = 24;
  int located = 0;
  for (const double n : {1.0, 1.5, 3.0, 4.0, 8.0}) {
    for (const double aspect : {0.5, 1.0, 2.0}) {
      for (const double inside : {0.5, 0.7, 0.9, 0.97}) {
        const Eigen::Vector2d centre(inside * kHalf * aspect, 75);
        const BlobCentre object = Shape{kHalf * aspect, kHalf, n}.at(centre);
        ASSERT_TRUE(object.cut_off);
        EXPECT_LT(squared_sigmas(object, centre), kMany) << n << ", " << aspect << ", " << inside;
        located += object.cut_off_share < BlobCentre::kNotLocated;
      }
    }
  }
  EXPECT_GE(located, 40) << "of 60";
}

TEST(BlobCentre, WhatOnlyTouchesTheBorderIsHardlyCutOff) {
  const BlobCentre touching = Shape{12, 18}.at({11.5, 70});
  EXPECT_TRUE(touching.cut_off);
  EXPECT_LT((touching.px - Eigen::Vector2d(11.5, 70)).norm(), 1);
  const Eigen::Vector2d centre(60, 70);
  const BlobCentre with_streak = centre_of_pixels([&](const Eigen::Vector2d& pixel) {
    return (pixel - centre).norm() < 25 || (pixel.x() < centre.x() && std::abs(pixel.y() - centre.y()) < 2);
  });
  EXPECT_LT(squared_sigmas(with_streak, centre), kMany);
}

TEST(BlobCentre, IsNotLocatedInACornerOrWithLessThanHalfInside) {
  const auto not_located = [](const BlobCentre& object, const Eigen::Vector2d& centre) {
    return object.cut_off_share == BlobCentre::kNotLocated && squared_sigmas(object, centre) < kMany;
  };
  EXPECT_TRUE(not_located(Shape{20, 20}.at({15, 15}), {15, 15}));
  EXPECT_TRUE(not_located(Shape{20, 20}.at({-4, 70}), {-4, 70}));
  EXPECT_TRUE(not_located(Shape{300, 20}.at({100, 75}), {100, 75})) << "from border to border";
  EXPECT_TRUE(not_located(Shape{60, 10, 8}.at({20, 75}), {20, 75})) << "a bar that enters the image";
}

// The mask of a disc of which a few columns are left, without the ends of the first one.
TEST(BlobCentre, IsNotLocatedWhereAPixelDecidesWhetherTheCentreIsInside) {
  for (const double radius : {5.0, 10.0, 20.0}) {
    for (const double outside : {0.2, 0.5, 0.7}) {
      const Eigen::Vector2d centre(-outside * radius, 70);
      const double half_chord = std::sqrt(radius * radius - centre.x() * centre.x());
      const BlobCentre object = centre_of_pixels([&](const Eigen::Vector2d& pixel) {
        const bool end = pixel.x() < 1 && std::abs(pixel.y() - centre.y()) > half_chord - 1;
        return (pixel - centre).norm() < radius && !end;
      });
      EXPECT_TRUE(object.cut_off);
      EXPECT_EQ(object.cut_off_share, BlobCentre::kNotLocated) << radius << ", " << outside;
    }
  }
}

TEST(SphereContourFit, AtTheBorderItFitsWhatIsThere) {
  const CameraModel c = camera();
  const Eigen::Vector3d p(0.03 * 0.4 + 0.4 * (c.width - 1 - c.cx) / c.fx - 0.025, 0, 0.4);
  const cv::Mat image = picture(c, p, 0.03, {.noise = 2});
  const SphereContour disc = SphereContourFitter(c).fit(image, red_blobs(image).at(0));
  EXPECT_TRUE(disc.cut_off);
  const Eigen::Vector2d error = disc.ray() - p.hnormalized();
  constexpr double kLimit = 13.8;  // 99.9 % of chi^2 with two degrees of freedom
  EXPECT_LT(error.dot(disc.ray_covariance().inverse() * error), kLimit);
}

// Half of a contour locates a ball, also where it is not known to be one: the border explains what is missing.
TEST(SphereContourFit, ABallThatTheBorderCutsOffIsWhereItsCovarianceSays) {
  const CameraModel c = camera();
  const CounterRandom random(17);
  const Eigen::Vector3d light = Eigen::Vector3d(-1, -2, -1.5).normalized();
  constexpr double kRadius = 0.03;
  constexpr int kPictures = 80;
  int by_contour = 0, inside = 0;
  std::vector<double> errors_px;
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
    errors_px.push_back(c.fx * error.norm());
    EXPECT_LT(c.fx * std::sqrt(ball.ray_covariance().trace()), 0.2 * radius_px) << "a blob tells as much";
    inside += squared < 5.991;  // 95 % of chi^2 with two degrees of freedom
  }
  EXPECT_GE(by_contour, 0.9 * kPictures) << "nine of ten, as of balls with a stripe or more";
  std::ranges::nth_element(errors_px, errors_px.begin() + kPictures / 2);
  EXPECT_LT(errors_px[kPictures / 2], 0.2) << "a blob is right to a pixel or two";
  // Where 95 % are inside on average, 99 % of such samples have at least 88.75 % inside (71 of 80).
  EXPECT_GE(inside, 0.8875 * kPictures);
}

// A search region's part of the image, or a window, does not hold what it cuts off.
TEST(SphereContourFit, ABlobThatOnlyTheSearchedPartCutsOffIsNotLocated) {
  const CameraModel c = camera();
  cv::Mat image(c.height, c.width, CV_8UC3, cv::Scalar(120, 110, 100));
  cv::ellipse(image, {160, 120}, {20, 32}, 0, 0, 360, cv::Scalar(60, 50, 210), cv::FILLED);
  const auto occlusion_in = [&](const cv::Mat& shown, const cv::Rect& part) {
    const Blob blob = red_blobs(shown).at(0);
    EXPECT_EQ(blob.box & part, blob.box);
    return SphereContourFitter(c, SphereContourFitter::kOfAnything).fit(shown, blob, part).occlusion;
  };
  EXPECT_LT(occlusion_in(image, {100, 60, 120, 120}), BlobCentre::kNotLocated);
  cv::Mat cut_off = image.clone();
  cut_off.colRange(170, c.width) = cv::Scalar(120, 110, 100);
  EXPECT_EQ(occlusion_in(cut_off, {100, 60, 70, 120}), BlobCentre::kNotLocated);
}

// An arc of an ellipse fits a circle of another centre: the blob tells how far that may be off.
TEST(SphereContourFit, AnEllipseThatTheBorderCutsOffIsWhereItsCovarianceSays) {
  const CameraModel c = camera();
  for (const double aspect : {0.7, 0.8, 0.9, 1.1, 1.2, 1.4}) {
    for (const double inside : {0.3, 0.5, 0.7, 0.9}) {
      constexpr double kHalf = 30;
      const Eigen::Vector2d centre(inside * kHalf * aspect, 118);
      cv::Mat image(c.height, c.width, CV_8UC3, cv::Scalar(120, 110, 100));
      constexpr int kBits = 8, kParts = 1 << kBits;
      const auto fixed = [](double value) { return static_cast<int>(std::lround(value * kParts)); };
      cv::ellipse(image, {fixed(centre.x()), fixed(centre.y())}, {fixed(kHalf * aspect), fixed(kHalf)}, 0, 0, 360,
                  cv::Scalar(60, 50, 210), cv::FILLED, cv::LINE_AA, kBits);
      const SphereContour found =
          SphereContourFitter(c, SphereContourFitter::kOfAnything).fit(image, red_blobs(image).at(0));
      const Eigen::Vector2d error = found.ray() - c.ray(centre);
      constexpr double kMostOccluded = 0.22;  // that a match accepts
      if (found.occlusion > kMostOccluded) continue;
      EXPECT_LT(error.dot(found.ray_covariance().inverse() * error), kMany) << aspect << ", " << inside;
    }
  }
}

// Whatever hides the half of a disc or of a square: the middle of the rest is within 2.2 standard deviations of the
// centre, and of a whole disc, about nothing may be hidden.
TEST(BlobCentre, UpToHalfOfAnObjectMayBeHidden) {
  const Eigen::Vector2d middle(100, 75);
  for (double degrees = 0; degrees < 360; degrees += 20) {
    const double angle = degrees * M_PI / 180;
    const Eigen::Vector2d side(std::cos(angle), std::sin(angle)), across(-side.y(), side.x());
    for (const bool disc : {true, false}) {
      const auto half = [&](const Eigen::Vector2d& px) {
        const Eigen::Vector2d to(side.dot(px - middle), across.dot(px - middle));
        return to.x() > 0 && (disc ? to.norm() < 40 : to.cwiseAbs().maxCoeff() < 30);
      };
      const BlobCentre centre = centre_of_pixels(half);
      const Eigen::Vector2d off = centre.px - middle;
      const Eigen::Matrix2d covariance = centre.covariance + centre.occlusion_covariance;
      EXPECT_LT(off.dot(covariance.inverse() * off), 2.2 * 2.2) << degrees << (disc ? " disc" : " square");
      EXPECT_GT(off.dot(centre.covariance.inverse() * off), 16) << "or this test shows nothing";
    }
  }
  const BlobCentre whole = centre_of_pixels([&](const Eigen::Vector2d& px) { return (px - middle).norm() < 40; });
  EXPECT_LT(whole.occlusion_covariance.trace(), 0.1);
}

}  // namespace
}  // namespace multireach::vision
