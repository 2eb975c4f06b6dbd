#include "vision/stereo/stereo_match.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "tests/vision/stereo_pairs.hpp"

namespace multireach::vision {
namespace {

using namespace testing;

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

// Rays that pass each other outside of a thing are of two things, however uncertain the centroids of their blobs are. A
// part of a long target that is hidden in one image moves its centroid as far: where it is expected, it may.
TEST(StereoMatching, RaysThatMissEachOtherByMoreThanItsRadiusShowTwoThings) {
  constexpr double kRadiusPx = 20;
  const Prediction here{rig().X_WL * kBall, 1e-2 * Eigen::Matrix3d::Identity()};
  for (const double known : {kRadius, 0.0}) {
    for (const double share : {-1.1, -0.9, 0.9, 1.1}) {
      Pair pair = moved(pair_of(kBall), share * kRadiusPx);
      for (SphereContour* contour : {&pair.left, &pair.right}) {
        contour->kind = SphereContour::Kind::kCentroid;
        contour->covariance = std::pow(kRadiusPx / 2 / 500, 2) * Eigen::Matrix3d::Identity();
      }
      const auto status = [&](const std::optional<Prediction>& prediction) {
        return match_candidates({pair.left}, {pair.right}, prediction, {.radius_m = known}).status;
      };
      EXPECT_EQ(status(std::nullopt), std::abs(share) < 1 ? Status::kSeen : Status::kInconsistentPair) << share;
      EXPECT_EQ(status(here), Status::kSeen) << share;
    }
  }
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
  EXPECT_EQ(status(arc_of(kRadius, 0.6)), Status::kOccludedTooMuch)
      << "a ball that is partly occluded has its own size";
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
