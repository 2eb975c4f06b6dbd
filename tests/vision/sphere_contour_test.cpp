// Fits contours to pictures of spheres whose true centre and radius are known.
#include "vision/contour/sphere_contour.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>

#include "imaging/image_codec.hpp"
#include "imaging/jpeg_decoder.hpp"
#include "numeric/instruction_set.hpp"
#include "numeric/random.hpp"
#include "tests/vision/ball_picture.hpp"
#include "vision/stereo/stereo_match.hpp"

namespace multireach::vision {
namespace {

using Kind = SphereContour::Kind;

SphereContour measured(const CameraModel& camera, const cv::Mat& image) {
  const std::vector<Blob> blobs = red_blobs(image);
  EXPECT_FALSE(blobs.empty());
  return SphereContourFitter(camera).fit(image, blobs.at(0));
}

TEST(SphereContourFit, IsExactToHundredthsOfAPixelWherePicturesAreClean) {
  // Away from the optical axis the contour is an ellipse, and its middle is not the image of the sphere's centre.
  for (const bool distorted : {false, true}) {
    const CameraModel c = camera(distorted);
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.003, -0.004, 0.5), {0.14, 0.09, 0.4}, {-0.1, 0.05, 0.3}}) {
      constexpr double kRadius = 0.03;
      const SphereContour disc = measured(c, picture(c, p, kRadius, {}));
      ASSERT_EQ(disc.kind, Kind::kEdges);
      EXPECT_NEAR(c.fx * (disc.ray() - p.hnormalized()).norm(), 0, 0.03) << p.transpose();
      EXPECT_NEAR(c.fx * (disc.value.z() - kRadius / p.norm()), 0, 0.06) << p.transpose();
      EXPECT_NEAR((disc.centre_px - c.project(p)).norm(), 0, 0.03);
      EXPECT_GT(disc.visible_fraction, 0.97);
      EXPECT_EQ(disc.occlusion, 0);
      EXPECT_FALSE(disc.cut_off);
    }
  }
}

TEST(SphereContourFit, SmallDiscsBeforeBlackAreMeasuredByTheirEdges) {
  // Only brightness distinguishes these balls from the background, and the image has no noise, so the fitter could
  // wrongly trust the hue far more than the brightness.
  const CameraModel c = camera();
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d p(0.05 + 0.0007 * k, -0.03 + 0.0004 * k, 1 + 0.03 * k);
    const SphereContour disc = measured(c, picture(c, p, 0.02, {.wall_rgb = {2, 6, 1}}));
    EXPECT_EQ(disc.kind, Kind::kEdges) << "at " << p.z() << " m";
    EXPECT_LT((disc.centre_px - c.project(p)).norm(), 0.05) << "at " << p.z() << " m";
  }
}

TEST(SphereContourFit, CovarianceIsThatOfTheErrors) {
  const CameraModel c = camera();
  const CounterRandom random(7);
  double nees = 0;
  constexpr int kPictures = 40;
  for (int k = 0; k < kPictures; ++k) {
    const auto at = static_cast<uint64_t>(3 * k);
    const Eigen::Vector3d p(random.uniform(at, -0.1, 0.1), random.uniform(at + 1, -0.08, 0.08),
                            random.uniform(at + 2, 0.4, 0.9));
    const SphereContour disc = measured(c, picture(c, p, 0.025, {.noise = 10}));
    ASSERT_EQ(disc.kind, Kind::kEdges);
    const Eigen::Vector2d error = disc.ray() - p.hnormalized();
    nees += error.dot(disc.ray_covariance().inverse() * error) / 2;
  }
  // The mean over 40 pictures, of two coordinates each, has a standard deviation of 0.16.
  EXPECT_GT(nees / kPictures, 0.55);
  EXPECT_LT(nees / kPictures, 1.5);
}

// Chroma has half the resolution there. Where the wall is as bright as the ball, the edges do not tell, but the file
// does.
TEST(SphereContourFit, OfAJpegItsCovarianceCoversTheErrors) {
  const CameraModel c = camera();
  const CounterRandom random(8);
  ImageCodec codec;
  SphereContourFitter fitter(c);
  double nees = 0;
  int inside = 0;
  constexpr int kPictures = 40;
  for (int k = 0; k < kPictures; ++k) {
    const auto at = static_cast<uint64_t>(3 * k);
    const Eigen::Vector3d p(random.uniform(at, -0.1, 0.1), random.uniform(at + 1, -0.08, 0.08),
                            random.uniform(at + 2, 0.4, 0.9));
    const std::vector<uint8_t> jpeg =
        codec.encode_jpeg(picture(c, p, 0.025, {.wall_rgb = {92, 102, 100}, .noise = 3}), 90);
    cv::Mat image;
    ASSERT_TRUE(
        codec.decode({.width = c.width, .height = c.height, .format = PixelFormat::kMjpeg, .data = jpeg}, image));
    const std::vector<Blob> blobs = red_blobs(image);
    ASSERT_FALSE(blobs.empty());
    const SphereContour disc =
        fitter.fit(image, blobs.front(), {0, 0, c.width, c.height}, jpeg_chroma_subsampled(jpeg));
    ASSERT_EQ(disc.kind, Kind::kEdges);
    const Eigen::Vector2d error = disc.ray() - p.hnormalized();
    const double squared = error.dot(disc.ray_covariance().inverse() * error);
    nees += squared / 2;
    inside += squared < 5.991;  // 95 % of chi^2 with two degrees of freedom
  }
  EXPECT_LT(nees / kPictures, 1.25);
  EXPECT_GE(inside, 0.95 * kPictures);
}

// A stripe's edges are at other places than the ball's colour and light tell. Contour by contour they mislead the fit;
// with the known radius, the position's covariance covers it. Of these positions a covariance that does not know of
// stripes covers 65 of 78.
TEST(SphereContourFit, TheCovarianceOfAStripedBallCoversTheErrors) {
  StereoRig rig;
  rig.left = rig.right = camera();
  rig.X_RL = rig.X_WL = Eigen::Isometry3d::Identity();
  rig.X_RL.translation().x() = -0.06;
  constexpr double kRadius = 0.025;
  const cv::Rect whole(0, 0, rig.left.width, rig.left.height);
  SphereContourFitter fitter(rig.left);
  const CounterRandom random(13);
  int seen = 0, inside = 0;
  double nees = 0;
  constexpr int kPairs = 80;
  for (int k = 0; k < kPairs; ++k) {
    const auto uniform = [&](int which, double from, double to) {
      return random.uniform(static_cast<uint64_t>(6 * k + which), from, to);
    };
    const Eigen::Vector3d p(uniform(0, -0.06, 0.1), uniform(1, -0.08, 0.08), uniform(2, 0.35, 0.5));
    const Eigen::Vector3d axis(uniform(3, -1, 1), uniform(4, -1, 1), uniform(5, -1, 1));
    const double wall = k % 3 == 0 ? 30 : k % 3 == 1 ? 100 : 190;
    const Scene striped{.wall_rgb = {wall, wall + 5, wall + 10},
                        .noise = 3,
                        .light = Eigen::Vector3d(-1, -2, -1.5).normalized(),
                        .stripe_axis = axis.normalized()};
    std::array<std::vector<SphereContour>, 2> contours;
    for (size_t side = 0; side < 2; ++side) {
      const cv::Mat image = picture(rig.left, side == 0 ? p : rig.X_RL * p, kRadius, striped);
      for (const Blob& blob : red_blobs(image)) contours[side].push_back(fitter.fit(image, blob, whole));
    }
    const StereoMatch match = match_candidates(rig, contours[0], contours[1], std::nullopt, {.radius_m = kRadius});
    if (match.status != StereoMatch::Status::kSeen) continue;
    const Eigen::Vector3d error = match.point.p_W - p;
    const double squared = error.dot(match.covariance().ldlt().solve(error));
    ++seen;
    nees += squared / 3;
    inside += squared < 7.815;  // 95 % of chi^2 with three degrees of freedom
  }
  EXPECT_GE(seen, 0.75 * kPairs);
  EXPECT_LT(nees / seen, 1.25);
  // Where 95 % are inside on average, 99 % of such samples have at least 88.75 % inside (71 of 80).
  EXPECT_GE(inside, 0.8875 * seen);
}

TEST(SphereContourFit, WhatIsHiddenIsRejectedAndDeclared) {
  const CameraModel c = camera();
  const Eigen::Vector3d p(0.02, 0.01, 0.45);
  const double r = c.fx * 0.03 / p.z();
  const Eigen::Vector2d centre = c.project(p);
  // A straight occluding edge at `at` times the radius from the centre occludes the fraction `share` of a disc's area.
  for (const auto& [at, share] : {std::pair(0.687, 0.1), {0.3, 0.312}}) {
    Scene scene;
    scene.noise = 3;
    scene.hides = [&, from = at * r](double x, double y) {
      return 0.6 * (x - centre.x()) + 0.8 * (y - centre.y()) > from;
    };
    const SphereContour disc = measured(c, picture(c, p, 0.03, scene));
    ASSERT_EQ(disc.kind, Kind::kEdges) << share;
    EXPECT_NEAR(disc.occlusion, share, 0.05);
    EXPECT_LT(disc.visible_fraction, 0.85);
    const Eigen::Vector2d error = disc.ray() - p.hnormalized();
    EXPECT_LT(c.fx * error.norm(), 0.25) << share;
    EXPECT_LT(error.dot(disc.ray_covariance().inverse() * error), 14) << "one in a thousand";
  }
}

/// Two cameras side by side, 6 cm apart.
StereoRig two_cameras() {
  StereoRig rig;
  rig.left = rig.right = camera();
  rig.X_RL = rig.X_WL = Eigen::Isometry3d::Identity();
  rig.X_RL.translation().x() = -0.06;
  return rig;
}

/// What a pair of pictures of the ball at `p` says; `picture_at(p_CB)` makes one.
template <typename PictureAt>
StereoMatch matched(const Eigen::Vector3d& p, double radius_m, const PictureAt& picture_at) {
  const StereoRig rig = two_cameras();
  const double least = radius_m > 0 ? SphereContourFitter::kOfASphere : SphereContourFitter::kOfAnything;
  SphereContourFitter fitter(camera(), least);
  std::array<std::vector<SphereContour>, 2> contours;
  for (size_t side = 0; side < 2; ++side) {
    const cv::Mat image = picture_at(side == 0 ? p : Eigen::Vector3d(rig.X_RL * p));
    for (const Blob& blob : red_blobs(image)) contours[side].push_back(fitter.fit(image, blob));
  }
  MatchOptions options;
  options.radius_m = radius_m;
  return match_candidates(rig, contours[0], contours[1], std::nullopt, options);
}

double squared_sigmas(const StereoMatch& match, const Eigen::Vector3d& p) {
  const Eigen::Vector3d apart = match.point.p_W - p;
  return apart.dot(match.covariance().inverse() * apart);
}

constexpr double kOneInAThousand = 16.3;  // of chi^2 with three degrees of freedom

TEST(SphereContourFit, WhatMayBeHiddenOfAnUnknownObjectIsInTheCovariance) {
  // Half a disc may be half a ball or a whole object of that shape: without a radius nobody knows.
  const CameraModel c = camera();
  const Eigen::Vector3d p(0.03, -0.01, 0.4);
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector2d way(std::cos(0.8 * k), std::sin(0.8 * k));
    const StereoMatch match = matched(p, 0, [&](const Eigen::Vector3d& p_CB) {
      Scene scene;
      scene.noise = 3;
      const Eigen::Vector2d centre = c.project(p_CB);
      scene.hides = [&](double x, double y) { return way.dot(Eigen::Vector2d(x, y) - centre) > 0; };
      return picture(c, p_CB, 0.03, scene);
    });
    EXPECT_EQ(match.occlusion, SphereContour::kUnknown) << k;
    ASSERT_EQ(match.status, StereoMatch::Status::kSeen) << k << ": " << description(match.status);
    EXPECT_LT(squared_sigmas(match, p), kOneInAThousand) << k;
  }
}

/// The mean of pictures of a ball that moves by `motion_px` in the direction `way` while they are exposed.
cv::Mat moved_picture(const CameraModel& c, const Eigen::Vector3d& p_CB, double radius_m, double motion_px,
                      const Eigen::Vector3d& way, const Scene& scene) {
  constexpr int kInstants = 16;
  cv::Mat sum = cv::Mat::zeros(c.height, c.width, CV_32FC3);
  for (int i = 0; i < kInstants; ++i) {
    const double share = (i + 0.5) / kInstants - 0.5;
    cv::Mat at;
    picture(c, p_CB + share * motion_px * p_CB.z() / c.fx * way, radius_m, scene).convertTo(at, CV_32FC3);
    sum += at / kInstants;
  }
  cv::Mat image;
  sum.convertTo(image, CV_8UC3);
  return image;
}

TEST(SphereContourFit, ABallThatMovesByItsRadiusIsWhereItsCovarianceSays) {
  const CameraModel c = camera();
  const Eigen::Vector3d p(0.02, 0.01, 0.4);
  constexpr double kMotionPx = 20, kRadius = 0.016;
  Scene scene;
  scene.noise = 3;
  scene.light = Eigen::Vector3d(-0.4, -0.8, -0.45).normalized();
  for (const double known : {0.0, kRadius}) {
    for (int k = 0; k < 6; ++k) {
      const Eigen::Vector3d way(std::cos(0.55 * k), std::sin(0.55 * k), 0);
      const StereoMatch match = matched(p, known, [&](const Eigen::Vector3d& p_CB) {
        return moved_picture(c, p_CB, kRadius, kMotionPx, way, scene);
      });
      if (match.status != StereoMatch::Status::kSeen) continue;  // is not tracked, and says why
      EXPECT_LT(squared_sigmas(match, p), kOneInAThousand) << "radius " << known << ", direction " << k;
    }
  }
}

TEST(SphereContourFit, ABallThatMovesALittleIsMeasuredByItsContour) {
  const CameraModel c = camera();
  const Eigen::Vector3d p(0.02, 0.01, 0.4);
  constexpr double kRadius = 0.02;
  Scene scene;
  scene.noise = 3;
  scene.light = Eigen::Vector3d(-0.4, -0.8, -0.45).normalized();
  for (const double motion_px : {4.0, 8.0}) {
    for (int k = 0; k < 6; ++k) {
      const Eigen::Vector3d way(std::cos(0.55 * k), std::sin(0.55 * k), 0);
      const StereoMatch match = matched(p, kRadius, [&](const Eigen::Vector3d& p_CB) {
        return moved_picture(c, p_CB, kRadius, motion_px, way, scene);
      });
      ASSERT_EQ(match.status, StereoMatch::Status::kSeen) << motion_px << " px, direction " << k;
      EXPECT_TRUE(match.both_by_contour) << motion_px << " px, direction " << k;
      EXPECT_LT(squared_sigmas(match, p), kOneInAThousand) << motion_px << " px, direction " << k;
    }
  }
}

TEST(SphereContourFit, AStripedBallIsWhereItsCovarianceSays) {
  const CameraModel c = camera();
  const CounterRandom random(31);
  const Eigen::Vector3d p(0.02, 0.01, 0.3);
  constexpr double kRadius = 0.02;
  double nees = 0;
  int seen = 0;
  constexpr int kPairs = 20;
  for (int k = 0; k < kPairs; ++k) {
    const auto at = static_cast<uint64_t>(3 * k);
    Scene scene;
    scene.noise = 3;
    scene.wall_rgb = {200, 205, 210};  // nearly the colour of the stripe
    scene.light = Eigen::Vector3d(-0.4, -0.8, -0.45).normalized();
    scene.stripe_axis =
        Eigen::Vector3d(random.uniform(at, -1, 1), random.uniform(at + 1, -1, 1), random.uniform(at + 2, -1, 1))
            .normalized();
    const StereoMatch match =
        matched(p, kRadius, [&](const Eigen::Vector3d& p_CB) { return picture(c, p_CB, kRadius, scene); });
    if (match.status != StereoMatch::Status::kSeen) continue;  // is not tracked, and says why
    ++seen;
    nees += squared_sigmas(match, p) / 3;
  }
  // The mean of 20 pairs, of three dimensions each, is below 1.5 with a probability of 99 %.
  EXPECT_LT(nees / seen, 1.5);
  EXPECT_GE(seen, kPairs / 2);
}

SurfaceColour surface_colour(const Eigen::Vector3d& normal, const Eigen::Vector3d& bgr) {
  const double x = normal.x(), y = normal.y(), z = normal.z();
  const std::array<double, SurfaceColour::kNumbers> numbers = {
      1, x, y, z, x * y, x * z, y * z, x * x - y * y, 3 * z * z - 1, bgr.x(), bgr.y(), bgr.z()};
  SurfaceColour colour;
  std::ranges::copy(numbers, colour.numbers.begin());
  return colour;
}

TEST(SurfaceShading, AStripeDoesNotChangeTheShading) {
  const auto shade = [](const Eigen::Vector3d& normal) {
    return Eigen::Vector3d(Eigen::Vector3d(60, 50, 210) * (0.6 + 0.3 * normal.y()));
  };
  std::vector<SurfaceColour> surface;
  constexpr int kPoints = 120, kWhite = 16;
  for (int k = 0; k < kPoints; ++k) {
    const double turn = 2 * 3.14159265 * k / kPoints, sine = k % 2 == 0 ? 0.9 : 0.75;
    const Eigen::Vector3d normal(sine * std::cos(turn), sine * std::sin(turn), std::sqrt(1 - sine * sine));
    surface.push_back(surface_colour(normal, k < kWhite ? Eigen::Vector3d(225, 230, 230) : shade(normal)));
  }
  SurfaceShading plain, robust;
  plain.fit(surface, true);
  robust.fit(surface, false);
  const auto error = [&](const SurfaceShading& fitted) {
    double largest = 0;
    for (const SurfaceColour& point : surface) {
      const Eigen::Vector3d colour = fitted.shading().colour(point.terms()), normal = point.terms().segment<3>(1);
      largest = std::max(largest, (colour - shade(normal)).norm());
    }
    return largest;
  };
  EXPECT_LT(error(robust), 2) << "grey levels: one per cent of the colour";
  EXPECT_GT(error(plain), 2) << "or this test shows nothing";
}

TEST(SphereContourFit, WhatIsNoDiscIsMeasuredByItsMiddleAndSaysSo) {
  const CameraModel c = camera();
  cv::Mat image(c.height, c.width, CV_8UC3, cv::Scalar(120, 110, 100));
  image(cv::Rect(100, 80, 70, 24)).setTo(cv::Scalar(60, 50, 210));
  const SphereContour bar = measured(c, image);
  EXPECT_EQ(bar.kind, Kind::kCentroid);
  EXPECT_NEAR((bar.centre_px - Eigen::Vector2d(134.5, 91.5)).norm(), 0, 1e-6);
  const double along = c.fx * std::sqrt(bar.covariance(0, 0)), across = c.fx * std::sqrt(bar.covariance(1, 1));
  EXPECT_GT(along, 2) << "the middle of what is seen may be several pixels from that of the object";
  EXPECT_LT(along, 10);
  EXPECT_LT(across, along);
}

TEST(SphereContourFit, TellsHowFarTheCentreOfALargerObjectMayBe) {
  const CameraModel c = camera();
  cv::Mat image(c.height, c.width, CV_8UC3, cv::Scalar(120, 110, 100));
  cv::ellipse(image, {150, 120}, {60, 14}, 30, 0, 360, cv::Scalar(60, 50, 210), cv::FILLED);  // a panel
  Blob blob = red_blobs(image).at(0);
  SphereContourFitter fitter(c);
  EXPECT_EQ(fitter.fit(image, blob).alternative_size, 0);
  blob.alternative_area = blob.area;
  const SphereContour all = fitter.fit(image, blob);
  EXPECT_GT(all.alternative_spread.trace(), 0) << "something may hide a part of it";
  EXPECT_EQ(all.alternative_size, all.value.z()) << "the blob is all of it";
  blob.alternative_area = 4 * blob.area;
  const Eigen::Vector2d apart(-10, 20);
  blob.alternative_spread = apart * apart.transpose();
  const SphereContour part = fitter.fit(image, blob);
  ASSERT_EQ(part.kind, Kind::kCentroid);
  const Eigen::Vector2d focal(c.fx, c.fy);
  const Eigen::Matrix2d spread_px =
      focal.asDiagonal() * (part.alternative_spread - all.alternative_spread) * focal.asDiagonal();
  EXPECT_LT((spread_px - blob.alternative_spread).norm(), 1e-6);
  EXPECT_NEAR(part.alternative_size, 2 * part.value.z(), 1e-9);
}

TEST(SphereContourFit, AnswersWhateverTheBlobIs) {
  const CameraModel c = camera();
  const cv::Mat red(c.height, c.width, CV_8UC3, cv::Scalar(60, 50, 210));
  SphereContourFitter measurer(c);
  const SphereContour all = measurer.fit(red, red_blobs(red).at(0));
  EXPECT_EQ(all.kind, Kind::kCentroid);
  EXPECT_TRUE(all.cut_off);
  const Blob pixel{.runs = {{10, 20, 21}}, .box = {20, 10, 1, 1}, .area = 1, .centroid = {20, 10}};
  const Blob corner{.runs = {{239, 319, 320}}, .box = {319, 239, 1, 1}, .area = 1, .centroid = {319, 239}};
  const Blob line{.runs = {{0, 0, 320}}, .box = {0, 0, 320, 1}, .area = 320, .centroid = {159.5, 0}};
  for (const Blob& blob : {pixel, corner, line}) {
    const SphereContour disc = measurer.fit(red, blob);
    EXPECT_EQ(disc.kind, Kind::kCentroid);
    EXPECT_TRUE(disc.value.allFinite() && disc.covariance.allFinite());
    EXPECT_GT(disc.covariance(0, 0), 0);
  }
}

TEST(SphereContourFit, DoesNotDependOnTheInstructionSet) {
  const CameraModel c = camera(true);
  Scene scene{.noise = 3, .light = Eigen::Vector3d(-0.4, -0.8, -0.45).normalized()};
  scene.hides = [](double x, double) { return x < 150; };
  const cv::Mat image = picture(c, {0, 0.01, 0.4}, 0.03, scene);
  std::optional<SphereContour> widest;
  for (const std::string& name : available_instruction_sets()) {
    ASSERT_TRUE(select_instruction_set(name));
    const SphereContour disc = measured(c, image);
    if (!widest) widest = disc;
    EXPECT_EQ(disc.kind, Kind::kEdges) << name;
    EXPECT_EQ(disc.value, widest->value) << name;
    EXPECT_EQ(disc.covariance, widest->covariance) << name;
    EXPECT_EQ(disc.residual_px, widest->residual_px) << name;
  }
  select_instruction_set("");
}

TEST(SphereContourFit, KeepsNothingFromOneDiscToTheNext) {
  const CameraModel c = camera();
  const cv::Mat first = picture(c, {0.02, 0.01, 0.45}, 0.03, {.noise = 3});
  const cv::Mat second = picture(c, {-0.05, 0.02, 0.3}, 0.03, {.noise = 3});
  SphereContourFitter warm(c);
  warm.fit(second, red_blobs(second).at(0));
  const SphereContour again = warm.fit(first, red_blobs(first).at(0)), fresh = measured(c, first);
  EXPECT_EQ(again.value, fresh.value);
  EXPECT_EQ(again.covariance, fresh.covariance);
}

}  // namespace
}  // namespace multireach::vision
