// How far a match is trusted that something contradicts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "tests/vision/stereo_pairs.hpp"

namespace multireach::vision {
namespace {

using namespace testing;

/// The pair as a camera system sees it that differs from the calibration.
Pair seen_by(const StereoRig& real, const Eigen::Vector3d& p_L) {
  return {disc_of(real.left, p_L), disc_of(real.right, real.X_RL * p_L)};
}

TEST(StereoMatching, AWrongCalibrationContradictsAKnownRadius) {
  StereoRig wide = rig(), turned = rig();
  wide.X_RL.translation() *= 1.1;
  turned.X_RL.prerotate(Eigen::AngleAxisd(M_PI / 180, Eigen::Vector3d::UnitY()));
  for (const StereoRig& real : {wide, turned}) {
    const Pair ball = seen_by(real, kBall);
    const StereoMatch match = match_candidates({ball.left}, {ball.right});
    EXPECT_EQ(match.status, Status::kWrongRadius) << "off by " << (match.point.p_W - rig().X_WL * kBall).norm();
    EXPECT_EQ(match_candidates({ball.left}, {ball.right}, std::nullopt, {}).status, Status::kSeen)
        << "without a radius there is nothing that contradicts";
  }
  const Pair ball = pair_of(kBall, 1.03 * kRadius);
  EXPECT_EQ(match_candidates({ball.left}, {ball.right}).status, Status::kSeen) << "3 % are not a contradiction";
}

TEST(StereoMatching, AKnownRadiusAllowsForTheErrorsOfTheCalibration) {
  StereoRig wide = rig(), doubtful = rig();
  wide.X_RL.translation() *= 1.1;
  const Pair ball = seen_by(wide, kBall);
  const auto status = [&] {
    return vision::match_candidates(doubtful, std::vector{ball.left}, std::vector{ball.right}, std::nullopt,
                                    {.radius_m = kRadius})
        .status;
  };
  doubtful.errors.covariance(RigErrors::kBaseline, RigErrors::kBaseline) = 0.005 * 0.005;
  EXPECT_EQ(status(), Status::kWrongRadius);
  doubtful.errors.covariance(RigErrors::kBaseline, RigErrors::kBaseline) = 0.03 * 0.03;
  EXPECT_EQ(status(), Status::kSeen);
}

TEST(StereoMatching, AContourOfAnotherSizeThanTheKnownOneIsTrustedLess) {
  // Edges at wrong places on one side of the left contour: 0.3 px smaller, and its centre as far away.
  const Pair ball = pair_of(kBall);
  constexpr double kOffPx = 0.3, kPx = 1 / 500.0, kOneInAThousand = 16.3;
  SphereContour smaller = ball.left;
  smaller.value += Eigen::Vector3d(kOffPx * kPx, 0, -kOffPx * kPx);
  const auto squared_sigmas = [](const StereoMatch& match) {
    const Eigen::Vector3d apart = match.point.p_W - rig().X_WL * kBall;
    return apart.dot(match.point.covariance.inverse() * apart);
  };
  const StereoMatch match = match_candidates({smaller}, {ball.right});
  ASSERT_EQ(match.status, Status::kSeen);
  EXPECT_LT(squared_sigmas(match), kOneInAThousand);
  const StereoMatch unknown = match_candidates({smaller}, {ball.right}, std::nullopt, {});
  EXPECT_GT(squared_sigmas(unknown), kOneInAThousand) << "without a radius there is nothing that contradicts";

  SphereContour half = ball.left;  // of something else, whatever its errors are
  half.value.z() *= 0.5;
  SphereContour half_right = ball.right;
  half_right.value.z() *= 0.5;
  half.covariance *= 40000;
  half_right.covariance *= 40000;
  EXPECT_EQ(match_candidates({half}, {half_right}).status, Status::kWrongRadius);
}

constexpr double k95 = 7.815;  // 95 % of chi^2 with three degrees of freedom

/// A ball's blob instead of its contour.
SphereContour blob_of(SphereContour disc) {
  disc.kind = SphereContour::Kind::kCentroid;
  disc.visible_fraction = 0;
  constexpr double kTenth = 0.1, kSize = 0.3;  // of the radius
  disc.covariance = Eigen::Vector3d(kTenth, kTenth, kSize).cwiseAbs2().asDiagonal();
  disc.covariance *= disc.value.z() * disc.value.z();
  return disc;
}

constexpr double kHalfDisc = 0.42;  // of the radius: from a disc's centre to the centroid of its half

double squared_sigmas_of_ball(const StereoMatch& match) {
  const Eigen::Vector3d apart = match.point.p_W - rig().X_WL * kBall;
  return apart.dot(match.covariance().ldlt().solve(apart));
}

// A stripe divides a ball: the blob is one part of it, and its centroid lies beside the ball's centre, alike in both
// images.
TEST(StereoMatching, ACentroidOfASmallerBlobThanTheKnownBallsIsTrustedLess) {
  const auto squared_sigmas = [&](double share) {
    Pair ball = pair_of(kBall);
    for (SphereContour* side : {&ball.left, &ball.right}) {
      *side = blob_of(*side);
      side->value.x() += kHalfDisc * side->value.z();
      side->value.z() *= share;
    }
    return squared_sigmas_of_ball(match_candidates({ball.left}, {ball.right}));
  };
  EXPECT_LT(squared_sigmas(std::sqrt(0.5)), k95);
  EXPECT_GT(squared_sigmas(1), 2 * k95) << "where nothing tells";
}

// One camera sees half of an object in a light in which it has not the learned colours.
TEST(StereoMatching, BlobsOfDifferentSizesAreTrustedLess) {
  const auto squared_sigmas = [&](double share) {
    const Pair ball = pair_of(kBall);
    SphereContour part = blob_of(ball.right);
    part.value.x() += kHalfDisc * part.value.z();
    part.value.z() *= share;
    return squared_sigmas_of_ball(match_candidates({blob_of(ball.left)}, {part}, std::nullopt, {}));
  };
  EXPECT_LT(squared_sigmas(std::sqrt(0.5)), k95);
  EXPECT_GT(squared_sigmas(1), k95) << "where nothing tells";
}

// Both images show the same panel of a ball, which may be a part of a larger object: its surface is nearer than the
// ball's centre, and to one side of it.
TEST(StereoMatching, APartOfAnObjectIsTrustedLess) {
  const auto squared_sigmas = [&](const Eigen::Vector3d& panel, double radius, bool told) {
    const StereoRig r = rig();
    std::array<SphereContour, 2> sides{blob_of(disc_of(r.left, panel, radius)),
                                       blob_of(disc_of(r.right, r.X_RL * panel, radius))};
    const std::array<SphereContour, 2> whole{disc_of(r.left, kBall), disc_of(r.right, r.X_RL * kBall)};
    for (size_t k = 0; k < 2 && told; ++k) {
      const Eigen::Vector2d apart = (whole[k].value - sides[k].value).head<2>();
      sides[k].alternative_spread = apart * apart.transpose();
      sides[k].alternative_size = whole[k].value.z();
    }
    return squared_sigmas_of_ball(match_candidates({sides[0]}, {sides[1]}, std::nullopt, {}));
  };
  const Eigen::Vector3d aside = kBall + kRadius * Eigen::Vector3d(0.5, 0, -std::sqrt(0.75));
  EXPECT_LT(squared_sigmas(aside, 0.5 * kRadius, true), k95);
  EXPECT_GT(squared_sigmas(aside, 0.5 * kRadius, false), k95) << "where nothing tells";
  // Of a patch on the front, the way to the centre is at most one standard deviation aside and one along the ray.
  for (const double share : {0.3, 0.5, 0.7, 0.9}) {
    const Eigen::Vector3d front = kBall - kRadius * std::sqrt(1 - share * share) * kBall.normalized();
    EXPECT_LT(squared_sigmas(front, share * kRadius, true), 2) << share;
  }
}

TEST(StereoMatching, WhatIsSeenMayBeOffOneLineAndSaysSo) {
  const Pair ball = pair_of(kBall);
  SphereContour lower = blob_of(ball.right);
  lower.value.y() += 6 / 500.0;
  lower.covariance(1, 1) = std::pow(5 / 500.0, 2);
  const StereoMatch good = match_candidates({blob_of(ball.left)}, {blob_of(ball.right)}, std::nullopt, {});
  const StereoMatch off = match_candidates({blob_of(ball.left)}, {lower}, std::nullopt, {});
  ASSERT_EQ(off.status, Status::kSeen) << description(off.status);
  EXPECT_STREQ(description_of_seen(good, {}), "seen");
  EXPECT_EQ(std::string(description_of_seen(off, {})).find("seen, but its two images are off one epipolar line"), 0U);
}

// Cameras that are turned towards each other, and a part that only the right one knows to be one: the centre is to the
// right of it in that camera's image.
TEST(StereoMatching, ThePartThatOneImageShowsIsInThatCamerasFrame) {
  StereoRig turned = rig();
  turned.X_RL.linear() = Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitY()).toRotationMatrix();
  turned.X_RL.translation() = turned.X_RL.linear() * Eigen::Vector3d(-0.3, 0, 0);
  const Eigen::Vector3d p_R = turned.X_RL * kBall;
  const SphereContour left = blob_of(disc_of(turned.left, kBall));
  SphereContour right = blob_of(disc_of(turned.right, p_R));
  right.alternative_spread(0, 0) = 0.1 * 0.1;
  right.alternative_size = right.value.z();
  const StereoMatch match =
      vision::match_candidates(turned, std::vector{left}, std::vector{right}, std::nullopt, MatchOptions{});
  ASSERT_EQ(match.status, StereoMatch::Status::kSeen) << description(match.status);
  const Eigen::Vector3d to_centre =
      turned.X_WL.linear() * (turned.X_RL.linear().transpose() * Eigen::Vector3d(0.1 * p_R.z(), 0, 0));
  EXPECT_LT((match.shape_covariance - to_centre * to_centre.transpose()).norm(), 1e-9);
}

// Strips, nearly along the rows, whose centres are known across them only, and cameras whose rows are off: moving the
// images along the strips explains that.
TEST(StereoMatching, AnElongatedBlobThatRowsMoveAlongItselfIsTrustedLess) {
  const Pair ball = pair_of(kBall);
  double worst = 0;
  for (const double slope : {-0.15, 0.15}) {
    for (const double off_px : {-5, -3, -2, -1, 1, 2, 3, 5}) {
      std::array<SphereContour, 2> sides{blob_of(ball.left), blob_of(ball.right)};
      const Eigen::Vector2d along = Eigen::Vector2d(1, slope).normalized(), across(-along.y(), along.x());
      for (SphereContour& side : sides)
        side.covariance.topLeftCorner<2, 2>() =
            std::pow(8 / 500.0, 2) * along * along.transpose() + std::pow(0.5 / 500.0, 2) * across * across.transpose();
      sides[1].value.y() += off_px / 500;
      const StereoMatch match = match_candidates({sides[0]}, {sides[1]}, std::nullopt, {});
      if (match.status != Status::kSeen) continue;
      EXPECT_LT(squared_sigmas_of_ball(match), k95) << slope << ", " << off_px << " px";
      const Eigen::Vector3d off = match.point.p_W - rig().X_WL * kBall;
      worst = std::max(worst, off.dot(match.point.covariance.inverse() * off));
    }
  }
  EXPECT_GT(worst, 5 * k95) << "or this test shows nothing";
}

// A strip 30 m away, 1 px of disparity, whose images may be anywhere along it.
TEST(StereoMatching, AnEstimateThatGoesToInfinityIsNotSeen) {
  const StereoRig r = rig();
  const Eigen::Vector3d far(0.2, 0.1, 30);
  std::array<SphereContour, 2> sides{blob_of(disc_of(r.left, far)), blob_of(disc_of(r.right, r.X_RL * far))};
  const Eigen::Vector2d along = Eigen::Vector2d(1, -0.15).normalized();
  for (SphereContour& side : sides)
    side.covariance.topLeftCorner<2, 2>() += std::pow(60 / 500.0, 2) * along * along.transpose();
  sides[1].value.y() += 7 / 500.0;
  const StereoMatch match = match_candidates({sides[0]}, {sides[1]}, std::nullopt, {});
  EXPECT_EQ(match.status, Status::kBehindCameras) << match.point.depth_left_m << " m";
}

// Cameras that are not synchronised, and an object that moves 4 px across the rows and as far along them in between.
TEST(StereoMatching, RaysThatMissEachOtherAreTrustedLess) {
  constexpr double kMovedPx = 4;
  const auto squared_sigmas = [&](double across_px) {
    const Pair ball = pair_of(kBall);
    SphereContour later = ball.right;
    later.value.head<2>() += Eigen::Vector2d(kMovedPx, across_px) / 500;
    return squared_sigmas_of_ball(match_candidates({ball.left}, {later}, std::nullopt, {.max_epipolar_px = 8}));
  };
  EXPECT_LT(squared_sigmas(kMovedPx), k95);
  EXPECT_GT(squared_sigmas(0), 100 * k95) << "where nothing tells";
}

TEST(StereoMatching, APositionIsSeenWhereItsContoursAre) {
  // Far away, rays that are hundreds of rows apart in the images still pass within centimetres of each other.
  for (const double radius : {kRadius, 0.0}) {
    for (const double rows : {30.0, 100.0, 394.0}) {
      Pair ball = pair_of({0, -0.3, 0.6});
      for (SphereContour* contour : {&ball.left, &ball.right}) {
        contour->kind = SphereContour::Kind::kCentroid;
        contour->covariance = std::pow(4 / 500.0, 2) * Eigen::Matrix3d::Identity();
      }
      ball.right.value.y() += rows / 500;
      ball.right.centre_px.y() += rows;
      for (const double disparity_px : {50.0, 0.3}) {
        ball.right.value.x() = ball.left.value.x() - disparity_px / 500;
        const StereoMatch match = match_candidates({ball.left}, {ball.right}, std::nullopt, {.radius_m = radius});
        if (match.status != Status::kSeen) continue;
        const Eigen::Vector3d p_L = rig().X_WL.inverse() * match.point.p_W;
        EXPECT_LT((rig().left.project(p_L) - ball.left.centre_px).norm(), 3 + 3 * 4 * 1.5) << rows;
        EXPECT_LT((rig().right.project(rig().X_RL * p_L) - ball.right.centre_px).norm(), 3 + 3 * 4 * 1.5) << rows;
      }
    }
  }
}

}  // namespace
}  // namespace multireach::vision
