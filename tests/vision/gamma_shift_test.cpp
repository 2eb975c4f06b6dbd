// Edges that a camera's gamma curve moves.
#include "vision/contour/gamma_shift.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "imaging/image_codec.hpp"
#include "tests/vision/ball_picture.hpp"
#include "vision/contour/sphere_contour.hpp"

namespace multireach::vision {
namespace {

/// By how much the area of the inside is measured too large, pixels, in the mean over the edge's positions in a pixel.
/// The edge is blurred by a box, and each pixel takes the mean of the light on it.
double seen_shift(double inside, double outside, double gamma, double box_px) {
  constexpr int kPlaces = 200, kPixels = 12, kSamples = 400;
  double sum = 0;
  for (int place = 0; place < kPlaces; ++place) {
    const double edge = 6 + (place + 0.5) / kPlaces;
    double area = 0;
    for (int pixel = 0; pixel < kPixels; ++pixel) {
      double light = 0;
      for (int sample = 0; sample < kSamples; ++sample) {
        const double x = pixel + (sample + 0.5) / kSamples;
        const double share = std::clamp((edge - x) / box_px + 0.5, 0.0, 1.0);
        light += (share * std::pow(inside, gamma) + (1 - share) * std::pow(outside, gamma)) / kSamples;
      }
      area += (std::pow(light, 1 / gamma) - outside) / (inside - outside);
    }
    sum += (area - edge) / kPlaces;
  }
  return sum;
}

TEST(GammaShift, IsThatOfTheMeanLightOnThePixels) {
  for (const double gamma : {1.5, 2.2, 3.0}) {
    const GammaShift shift(gamma);
    for (const auto& [inside, outside] : {std::pair(200.0, 100.0), {200.0, 20.0}, {30.0, 220.0}, {100.0, 97.0}}) {
      // Of a sharp edge, a pixel's share is equally likely anywhere from 0 to 1. Between the knots of the table, its
      // error is below a thousandth of a pixel.
      EXPECT_NEAR(shift.of_edge(inside, outside, 1), seen_shift(inside, outside, gamma, 1e-9), 1e-3)
          << gamma << ": " << inside << ", " << outside;
      // Blurred by a wide box, the edge is as wide as a box of the variance of both: about, by a share that is small
      // beside that which gamma_shift.cpp takes as its error (0.3).
      const double blurred = seen_shift(inside, outside, gamma, 6);
      EXPECT_NEAR(shift.of_edge(inside, outside, std::sqrt(1 + 36)), blurred, 0.05 * std::abs(blurred))
          << gamma << ": " << inside << ", " << outside;
    }
  }
  EXPECT_NEAR(GammaShift(2.2).of_edge(200, 100, 1), 0.07, 0.005) << "as docs/vision-accuracy.md says";
  EXPECT_NEAR(GammaShift(2.2).of_edge(200, 20, 1), 0.16, 0.005);
}

TEST(GammaShift, IsNothingWhereGreyLevelsAreProportionalToLight) {
  for (const double inside : {0.0, 20.0, 255.0}) EXPECT_EQ(GammaShift(1).of_edge(inside, 100, 1), 0);
  EXPECT_EQ(GammaShift(2.2).of_edge(100, 100, 1), 0);
  EXPECT_EQ(GammaShift(2.2).of_edge(0, 0, 1), 0);
}

/// Errors of contours of balls before a wall that is bright on one side of the ball only: there the curve of the camera
/// moves the centre.
struct Errors {
  double mean2_px2 = 0, nees = 0;  // each the mean; NEES of two coordinates, divided by two
};
Errors errors_with(std::optional<double> told, bool jpeg, const Scene& scene) {
  constexpr double kRadius = 0.025;
  constexpr int kPictures = 30;
  CameraModel c = camera();
  c.gamma = told;
  ImageCodec codec;
  const CounterRandom random(21);
  Errors errors;
  for (int k = 0; k < kPictures; ++k) {
    const auto at = static_cast<uint64_t>(3 * k);
    const Eigen::Vector3d p(random.uniform(at, -0.1, 0.1), random.uniform(at + 1, -0.08, 0.08),
                            random.uniform(at + 2, 0.3, 0.6));
    Scene divided = scene;
    divided.dark_from = c.project(p).x();
    cv::Mat image = picture(c, p, kRadius, divided);
    if (jpeg) {
      const std::vector<uint8_t> bytes = codec.encode_jpeg(image, 90);
      EXPECT_TRUE(
          codec.decode({.width = c.width, .height = c.height, .format = PixelFormat::kMjpeg, .data = bytes}, image));
    }
    const std::vector<Blob> blobs = red_blobs(image);
    const SphereContour contour = SphereContourFitter(c).fit(image, blobs.at(0), {0, 0, image.cols, image.rows}, jpeg);
    EXPECT_EQ(contour.kind, SphereContour::Kind::kEdges);
    const Eigen::Vector2d error = contour.ray() - p.hnormalized();
    errors.mean2_px2 += c.fx * c.fx * error.squaredNorm() / kPictures;
    errors.nees += error.dot(contour.ray_covariance().inverse() * error) / 2 / kPictures;
  }
  return errors;
}

// NEES of at most 1.25, as everywhere in docs/vision-accuracy.md.
TEST(SphereContourFit, AGammaCurveIsCorrectedWhereItIsKnownAndCoveredWhereItIsNot) {
  const Scene scene{.wall_rgb = {190, 200, 205}, .noise = 2, .gamma = 2.2};
  const Errors ignored = errors_with(1, false, scene), known = errors_with(2.2, false, scene),
               unknown = errors_with(std::nullopt, false, scene);
  EXPECT_GT(ignored.nees, 5) << "the curve matters here";
  EXPECT_LT(known.mean2_px2, 0.25 * ignored.mean2_px2);
  EXPECT_LT(known.nees, 1.25);
  EXPECT_EQ(unknown.mean2_px2, ignored.mean2_px2);
  EXPECT_LT(unknown.nees, 1.25);
}

TEST(SphereContourFit, OfAJpegAGammaCurveIsCovered) {
  const Scene scene{.wall_rgb = {190, 200, 205}, .noise = 2, .gamma = 2.2};
  for (const std::optional<double> told : {std::optional<double>(), std::optional(2.2)})
    EXPECT_LT(errors_with(told, true, scene).nees, 1.25) << "gamma told: " << told.has_value();
}

TEST(SphereContourFit, WhereABallIsOverexposedItsGammaCurveIsCoveredToo) {
  const Scene scene{.ball_rgb = {255, 60, 70}, .wall_rgb = {250, 255, 255}, .noise = 2, .gamma = 2.2};
  for (const std::optional<double> told : {std::optional<double>(), std::optional(2.2)})
    EXPECT_LT(errors_with(told, false, scene).nees, 1.25) << "gamma told: " << told.has_value();
}

}  // namespace
}  // namespace multireach::vision
