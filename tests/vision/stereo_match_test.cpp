#include "vision/stereo/stereo_match.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

namespace multireach::vision {
namespace {

using Status = StereoMatch::Status;
constexpr double kRadius = 0.02;

StereoRig rig() {
  StereoRig rig;
  rig.left = {.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240, .distortion = {}};
  rig.right = rig.left;
  rig.X_RL = rig.X_WL = Eigen::Isometry3d::Identity();
  rig.X_RL.translation() = Eigen::Vector3d(-0.06, 0, 0);
  rig.X_WL.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  rig.X_WL.translation() = Eigen::Vector3d(0.1, 0.2, 0.3);
  return rig;
}

/// The contour that a perfect camera would measure of a sphere.
SphereContour disc_of(const CameraModel& camera, const Eigen::Vector3d& p_C, double radius = kRadius,
                      double sigma_px = 0.03) {
  SphereContour disc;
  disc.kind = SphereContour::Kind::kEdges;
  disc.value << p_C.hnormalized(), radius / p_C.norm();
  disc.covariance = std::pow(sigma_px / camera.fx, 2) * Eigen::Matrix3d::Identity();
  disc.centre_px = camera.project(p_C);
  disc.radius_px = disc.value.z() * camera.fx;
  disc.area = M_PI * disc.radius_px * disc.radius_px;
  disc.visible_fraction = 1;
  return disc;
}

struct Pair {
  SphereContour left, right;
};
Pair pair_of(const Eigen::Vector3d& p_L, double radius = kRadius) {
  const StereoRig r = rig();
  return {disc_of(r.left, p_L, radius), disc_of(r.right, r.X_RL * p_L, radius)};
}

StereoMatch match_candidates(const std::vector<SphereContour>& left, const std::vector<SphereContour>& right,
                             const std::optional<Prediction>& prediction = std::nullopt,
                             const MatchOptions& options = {.radius_m = kRadius}) {
  return vision::match_candidates(rig(), left, right, prediction, options);
}

const Eigen::Vector3d kBall(0.03, -0.02, 0.5);

TEST(StereoMatching, PlaceAndSizeAreExactWithoutNoise) {
  const Pair ball = pair_of(kBall);
  for (const double known : {kRadius, 0.0}) {
    const StereoMatch match = match_candidates({ball.left}, {ball.right}, std::nullopt, {.radius_m = known});
    ASSERT_EQ(match.status, Status::kSeen) << description(match.status);
    EXPECT_LT((match.point.p_W - rig().X_WL * kBall).norm(), 1e-9);
    EXPECT_NEAR(match.point.radius_m, kRadius, 1e-9);
    EXPECT_NEAR(match.epipolar_px, 0, 1e-6);
    EXPECT_EQ(match.left, 0);
    EXPECT_EQ(match.right, 0);
  }
}

TEST(StereoMatching, TakesThePairThatFitsAmongOthers) {
  const Pair ball = pair_of(kBall), small = pair_of({-0.1, 0.05, 0.6}, 0.008),
             other = pair_of({-0.05, 0.08, 0.7}, 0.05);
  const StereoMatch match = match_candidates({other.left, small.left, ball.left}, {small.right, ball.right});
  ASSERT_EQ(match.status, Status::kSeen);
  EXPECT_EQ(match.left, 2);
  EXPECT_EQ(match.right, 1);
}

TEST(StereoMatching, OfTwoAlikeTheExpectedOneIsTaken) {
  const Eigen::Vector3d elsewhere(-0.1, 0.08, 0.5);
  const Pair first = pair_of(kBall), second = pair_of(elsewhere);
  for (const Eigen::Vector3d& p_L : {kBall, elsewhere}) {
    const Prediction prediction{rig().X_WL * (p_L + Eigen::Vector3d(0.01, 0, 0.01)),
                                1e-4 * Eigen::Matrix3d::Identity()};
    const StereoMatch match = match_candidates({first.left, second.left}, {second.right, first.right}, prediction);
    ASSERT_EQ(match.status, Status::kSeen);
    EXPECT_LT((match.point.p_W - rig().X_WL * p_L).norm(), 1e-6);
  }
  const Prediction far{rig().X_WL * Eigen::Vector3d(0.3, 0.3, 0.5), 1e-4 * Eigen::Matrix3d::Identity()};
  EXPECT_EQ(match_candidates({first.left}, {first.right}, far).status, Status::kOutsidePredictionGate);
}

// A sleeve at the border must not keep a ball that has bounced from being seen.
TEST(StereoMatching, WhatIsPartlyVisibleElsewhereIsNoBetterThanWhatIsAllVisibleThere) {
  const Pair ball = pair_of(kBall);
  Pair cut_off = pair_of({-0.1, 0.08, 0.5}, 0.03);
  for (SphereContour* contour : {&cut_off.left, &cut_off.right}) {
    contour->cut_off = true;
    contour->visible_fraction = 0.3;
    contour->occlusion = 0.5;
  }
  const Prediction far{rig().X_WL * Eigen::Vector3d(0.3, 0.3, 0.5), 1e-4 * Eigen::Matrix3d::Identity()};
  ASSERT_EQ(match_candidates({cut_off.left}, {cut_off.right}, far).status, Status::kCutOff);
  const StereoMatch match = match_candidates({cut_off.left, ball.left}, {cut_off.right, ball.right}, far);
  EXPECT_EQ(match.status, Status::kOutsidePredictionGate);
  EXPECT_EQ(match.left, 1);
}

TEST(StereoMatching, EachFaultHasItsOwnStatusAndSentence) {
  const Pair ball = pair_of(kBall);
  EXPECT_EQ(match_candidates({}, {ball.right}).status, Status::kNotInLeft);
  EXPECT_EQ(match_candidates({ball.left}, {}).status, Status::kNotInRight);
  EXPECT_EQ(match_candidates({ball.left}, {pair_of(kBall, 0.04).right}).status, Status::kInconsistentPair);
  EXPECT_EQ(match_candidates({ball.left}, {ball.right}, std::nullopt, {.radius_m = 0.04}).status, Status::kWrongRadius);

  Pair tilted = ball;  // as if a camera had been knocked out of place: 10 px
  tilted.right.value.y() += 10 / 500.0;
  const StereoMatch missed = match_candidates({tilted.left}, {tilted.right});
  EXPECT_EQ(missed.status, Status::kEpipolarMismatch);
  EXPECT_NEAR(missed.epipolar_px, 10, 0.2) << "the right ray passes below";
  EXPECT_FALSE(missed.fits_swapped);

  const StereoMatch swapped = match_candidates({ball.right}, {ball.left});
  EXPECT_EQ(swapped.status, Status::kBehindCameras);
  EXPECT_TRUE(swapped.fits_swapped);

  Pair hidden = ball;
  hidden.right.occlusion = 0.3;
  hidden.right.visible_fraction = 0.6;
  const StereoMatch declared = match_candidates({hidden.left}, {hidden.right});
  EXPECT_EQ(declared.status, Status::kOccludedTooMuch);
  EXPECT_EQ(declared.occlusion, 0.3);
  hidden.right.cut_off = true;
  EXPECT_EQ(match_candidates({hidden.left}, {hidden.right}).status, Status::kCutOff);
  hidden.right.occlusion = 0.1;
  EXPECT_EQ(match_candidates({hidden.left}, {hidden.right}).status, Status::kSeen);

  // Three quarters of a contour locate the centre, whatever its blob lacks.
  hidden.right.cut_off = false;
  hidden.right.visible_fraction = 0.76;
  hidden.right.occlusion = 0.24;
  EXPECT_EQ(match_candidates({hidden.left}, {hidden.right}).status, Status::kSeen);
  hidden.right.kind = SphereContour::Kind::kCentroid;
  EXPECT_EQ(match_candidates({hidden.left}, {hidden.right}).status, Status::kOccludedTooMuch);

  std::vector<std::string> sentences;
  for (int status = 0; status <= static_cast<int>(Status::kAmbiguous); ++status)
    sentences.emplace_back(description(static_cast<Status>(status)));
  std::ranges::sort(sentences);
  EXPECT_EQ(std::ranges::adjacent_find(sentences), sentences.end()) << "no sentence twice";
  EXPECT_FALSE(sentences.front().empty());
}

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

TEST(StereoMatching, OfTwoEqualBallsNoneIsSeenBetweenThem) {
  // Without a radius, the left image of one and the right image of the other make a third ball, nearer or farther.
  const Eigen::Vector3d near(-0.05, 0, 0.5), other(0.05, 0, 0.52);
  const Pair a = pair_of(near), b = pair_of(other);
  for (const auto& left : {std::vector{a.left, b.left}, {b.left, a.left}}) {
    for (const auto& right : {std::vector{a.right, b.right}, {b.right, a.right}}) {
      const StereoMatch match = match_candidates(left, right, std::nullopt, {});
      ASSERT_EQ(match.status, Status::kSeen);
      const Eigen::Vector3d p_L = rig().X_WL.inverse() * match.point.p_W;
      EXPECT_LT(std::min((p_L - near).norm(), (p_L - other).norm()), 1e-6) << p_L.transpose();
    }
  }
}

TEST(StereoMatching, AKnownRadiusHelpsWhereADirectionIsUnsure) {
  Pair ball = pair_of(kBall);
  ball.right.covariance(0, 0) *= 1e4;  // occluded on one side: the disparity is uncertain by 3 px
  const StereoMatch with = match_candidates({ball.left}, {ball.right});
  const StereoMatch without = match_candidates({ball.left}, {ball.right}, std::nullopt, {});
  EXPECT_LT(with.point.covariance.trace(), 0.2 * without.point.covariance.trace());
  // The radius of 20 px has an uncertainty of a tenth of a pixel, which gives 0.5 m * 0.1 / 20 in depth.
  EXPECT_NEAR(std::sqrt(with.point.covariance.trace()), 0.5 * 0.1 / 20, 0.5e-3);
}

/// Moves what the right image shows down, as if the right camera had been turned up.
Pair moved(Pair pair, double px) {
  pair.right.value.y() += px / 500;
  return pair;
}

TEST(StereoMatching, MoreMismatchesThanMatchesContradictTheCalibration) {
  const auto contradicted = [](const std::vector<Pair>& pairs, size_t located = 0) {
    std::vector<SphereContour> left, right;
    for (const Pair& pair : pairs) {
      left.push_back(pair.left);
      right.push_back(pair.right);
    }
    return contradiction_of(compare_pairs(rig(), left, right, std::nullopt, {}), rig(), located) != nullptr;
  };
  // By a right camera that is turned by 10 px, the left image of the first fits the right image of the second.
  const std::vector<Pair> balls{pair_of({0.05, -0.02, 0.5}), pair_of({-0.01, -0.03, 0.5}), pair_of({0.1, 0.03, 0.5}),
                                pair_of({-0.1, 0.09, 0.5})};
  EXPECT_FALSE(contradicted(balls));
  std::vector<Pair> turned;
  for (const Pair& ball : balls) turned.push_back(moved(ball, 10));
  EXPECT_EQ(match_candidates({turned[0].left}, {turned[1].right}, std::nullopt, {}).status, Status::kSeen);
  EXPECT_TRUE(contradicted(turned));
  EXPECT_FALSE(contradicted(turned, 4)) << "other targets are located";
  // One thing that only the left image shows and one that only the right image shows, beside a ball: as many as fit.
  EXPECT_FALSE(contradicted({balls[0], moved(balls[2], 10)}));
  // Off by more than a calibration can be: different things.
  EXPECT_FALSE(contradicted({balls[0], moved(balls[2], 30), moved(balls[3], 30)}));
  EXPECT_TRUE(contradicted({balls[0], moved(balls[2], 10), moved(balls[3], 10)}));
}

/// A ball of which 40 per cent of the contour shows, as an arc with this radius and residual, and its blob.
SphereContour arc_of(double radius, double residual_px, double blob_radius = 0.9 * kRadius) {
  SphereContour arc = disc_of(rig().left, kBall, radius), blob = disc_of(rig().left, kBall, blob_radius, 1);
  blob.kind = SphereContour::Kind::kCentroid;
  blob.occlusion = SphereContour::kUnknown;
  arc.visible_fraction = 0.4;
  arc.occlusion = 0.3;
  arc.residual_px = residual_px;
  arc.by_centroid = std::make_shared<SphereContour>(blob);
  return arc;
}

TEST(StereoMatching, TheBlobCountsWhereAnArcContradictsTheKnownRadius) {
  const SphereContour right = pair_of(kBall).right;
  const auto status = [&](const SphereContour& left, double known = kRadius) {
    return match_candidates({left}, {right}, std::nullopt, {.radius_m = known}).status;
  };
  const StereoMatch boxed = match_candidates({arc_of(1.25 * kRadius, 0.6)}, {right});  // as of a box around it
  ASSERT_EQ(boxed.status, Status::kSeen) << description(boxed.status);
  EXPECT_FALSE(boxed.both_by_contour);
  EXPECT_LT((boxed.point.p_W - rig().X_WL * kBall).norm(), 0.01);
  EXPECT_EQ(status(arc_of(kRadius, 0.6)), Status::kOccludedTooMuch) << "a ball that is partly hidden has its own size";
  EXPECT_EQ(status(arc_of(1.25 * kRadius, 0.1)), Status::kOccludedTooMuch) << "these edges are on a circle";
  EXPECT_EQ(status(arc_of(1.25 * kRadius, 0.6, 0.7 * kRadius)), Status::kOccludedTooMuch) << "the blob lacks half";
  EXPECT_EQ(status(arc_of(1.25 * kRadius, 0.6), 0), Status::kOccludedTooMuch) << "nothing tells without the radius";
}

TEST(StereoMatching, ABlobThatIsFarLargerThanTheKnownBallIsNotIt) {
  const auto match_of = [](double radius) {
    Pair blob = pair_of(kBall, radius);
    for (SphereContour* each : {&blob.left, &blob.right}) {
      each->kind = SphereContour::Kind::kCentroid;
      each->occlusion = SphereContour::kUnknown;
      each->covariance(2, 2) = std::pow(0.3 * each->value.z(), 2);  // the size is a rough estimate
    }
    return match_candidates({blob.left}, {blob.right});
  };
  EXPECT_EQ(match_of(kRadius).status, Status::kSeen);
  EXPECT_EQ(match_of(1.55 * kRadius).status, Status::kSeen) << "as of a ball that moved by more than its diameter";
  EXPECT_EQ(match_of(1.7 * kRadius).status, Status::kWrongRadius);
  // What makes a blob larger may be on one side: 30 per cent, less 10 of blur, of a radius of 20 px are 4 px.
  const auto sigma_of = [&](double radius) { return std::sqrt(match_of(radius).point.covariance.trace()); };
  const double by_px = 0.5 * 0.5 / (0.06 * 500);  // m of depth for a pixel of disparity
  EXPECT_LT(sigma_of(1.05 * kRadius), 0.1 * by_px);
  EXPECT_GT(sigma_of(1.3 * kRadius), 4 * by_px);
}

TEST(StereoMatching, HalvesOfTwoBallsAreNotOne) {
  // Two equal balls behind an edge that hides the half of each; left image of one, right image of the other.
  const StereoRig r = rig();
  const auto half = [&](const CameraModel& camera, const Eigen::Vector3d& p_C) {
    SphereContour arc = disc_of(camera, p_C), blob = disc_of(camera, p_C, 0.71 * kRadius, 1);
    blob.kind = SphereContour::Kind::kCentroid;
    blob.occlusion = SphereContour::kUnknown;
    arc.visible_fraction = arc.occlusion = 0.5;
    arc.residual_px = 0.1;
    arc.by_centroid = std::make_shared<SphereContour>(blob);
    return arc;
  };
  const Eigen::Vector3d other = kBall - Eigen::Vector3d(0.042, 0, 0);
  const std::vector<SphereContour> left{half(r.left, kBall), half(r.left, other)},
      right{half(r.right, r.X_RL * kBall), half(r.right, r.X_RL * other)};
  EXPECT_EQ(match_candidates(left, right).status, Status::kOccludedTooMuch);
}

}  // namespace
}  // namespace multireach::vision
