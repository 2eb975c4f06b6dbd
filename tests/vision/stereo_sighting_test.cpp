#include "vision/stereo/stereo_sighting.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace multireach::vision {
namespace {

using Status = Sighting::Status;
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

/// The measurement that a camera would have of a sphere, if it were perfect.
DiscMeasurement disc_of(const CameraModel& camera, const Eigen::Vector3d& p_C, double radius = kRadius,
                        double sigma_px = 0.03) {
  DiscMeasurement disc;
  disc.kind = DiscMeasurement::Kind::kEdges;
  disc.value << p_C.hnormalized(), radius / p_C.norm();
  disc.covariance = std::pow(sigma_px / camera.fx, 2) * Eigen::Matrix3d::Identity();
  disc.centre_px = camera.project(p_C);
  disc.radius_px = disc.value.z() * camera.fx;
  disc.area = M_PI * disc.radius_px * disc.radius_px;
  disc.outline_seen = 1;
  return disc;
}

struct Pair {
  DiscMeasurement left, right;
};
Pair pair_of(const Eigen::Vector3d& p_L, double radius = kRadius) {
  const StereoRig r = rig();
  return {disc_of(r.left, p_L, radius), disc_of(r.right, r.X_RL * p_L, radius)};
}

Sighting sight(const std::vector<DiscMeasurement>& left, const std::vector<DiscMeasurement>& right,
               const std::optional<Prediction>& prediction = std::nullopt,
               const SightingOptions& options = {.radius_m = kRadius}) {
  return vision::sight(rig(), left, right, prediction, options);
}

const Eigen::Vector3d kBall(0.03, -0.02, 0.5);

TEST(StereoSighting, PlaceAndSizeAreExactWithoutNoise) {
  const Pair ball = pair_of(kBall);
  for (const double known : {kRadius, 0.0}) {
    const Sighting sighting = sight({ball.left}, {ball.right}, std::nullopt, {.radius_m = known});
    ASSERT_EQ(sighting.status, Status::kSeen) << description(sighting.status);
    EXPECT_LT((sighting.point.p_W - rig().X_WL * kBall).norm(), 1e-9);
    EXPECT_NEAR(sighting.point.radius_m, kRadius, 1e-9);
    EXPECT_NEAR(sighting.epipolar_px, 0, 1e-6);
    EXPECT_EQ(sighting.left, 0);
    EXPECT_EQ(sighting.right, 0);
  }
}

TEST(StereoSighting, TakesThePairThatFitsAmongOthers) {
  const Pair ball = pair_of(kBall), small = pair_of({-0.1, 0.05, 0.6}, 0.008),
             other = pair_of({-0.05, 0.08, 0.7}, 0.05);
  const Sighting sighting = sight({other.left, small.left, ball.left}, {small.right, ball.right});
  ASSERT_EQ(sighting.status, Status::kSeen);
  EXPECT_EQ(sighting.left, 2);
  EXPECT_EQ(sighting.right, 1);
}

TEST(StereoSighting, OfTwoAlikeTheExpectedOneIsTaken) {
  const Eigen::Vector3d elsewhere(-0.1, 0.08, 0.5);
  const Pair first = pair_of(kBall), second = pair_of(elsewhere);
  for (const Eigen::Vector3d& p_L : {kBall, elsewhere}) {
    const Prediction prediction{rig().X_WL * (p_L + Eigen::Vector3d(0.01, 0, 0.01)),
                                1e-4 * Eigen::Matrix3d::Identity()};
    const Sighting sighting = sight({first.left, second.left}, {second.right, first.right}, prediction);
    ASSERT_EQ(sighting.status, Status::kSeen);
    EXPECT_LT((sighting.point.p_W - rig().X_WL * p_L).norm(), 1e-6);
  }
  const Prediction far{rig().X_WL * Eigen::Vector3d(0.3, 0.3, 0.5), 1e-4 * Eigen::Matrix3d::Identity()};
  EXPECT_EQ(sight({first.left}, {first.right}, far).status, Status::kNotWhereExpected);
}

TEST(StereoSighting, EachFaultHasItsOwnStatusAndSentence) {
  const Pair ball = pair_of(kBall);
  EXPECT_EQ(sight({}, {ball.right}).status, Status::kNotInLeft);
  EXPECT_EQ(sight({ball.left}, {}).status, Status::kNotInRight);
  EXPECT_EQ(sight({ball.left}, {pair_of(kBall, 0.04).right}).status, Status::kNotTheSame);
  EXPECT_EQ(sight({ball.left}, {ball.right}, std::nullopt, {.radius_m = 0.04}).status, Status::kOfOtherSize);

  Pair tilted = ball;  // as by a camera that was knocked: 10 px
  tilted.right.value.y() += 10 / 500.0;
  const Sighting missed = sight({tilted.left}, {tilted.right});
  EXPECT_EQ(missed.status, Status::kLinesOfSightMissed);
  EXPECT_NEAR(missed.epipolar_px, 10, 0.2) << "the right ray passes below";
  EXPECT_FALSE(missed.fits_exchanged);

  const Sighting swapped = sight({ball.right}, {ball.left});
  EXPECT_EQ(swapped.status, Status::kBehindCameras);
  EXPECT_TRUE(swapped.fits_exchanged);

  Pair hidden = ball;
  hidden.right.hidden = 0.3;
  const Sighting declared = sight({hidden.left}, {hidden.right});
  EXPECT_EQ(declared.status, Status::kHiddenTooMuch);
  EXPECT_EQ(declared.hidden, 0.3);
  hidden.right.cut_off = true;
  EXPECT_EQ(sight({hidden.left}, {hidden.right}).status, Status::kCutOff);

  std::vector<std::string> sentences;
  for (int status = 0; status <= static_cast<int>(Status::kNotWhereExpected); ++status)
    sentences.emplace_back(description(static_cast<Status>(status)));
  std::ranges::sort(sentences);
  EXPECT_EQ(std::ranges::adjacent_find(sentences), sentences.end()) << "no sentence twice";
  EXPECT_FALSE(sentences.front().empty());
}

TEST(StereoSighting, AKnownRadiusHelpsWhereADirectionIsUnsure) {
  Pair ball = pair_of(kBall);
  ball.right.covariance(0, 0) *= 1e4;  // hidden at one side: the disparity is not known to 3 px
  const Sighting with = sight({ball.left}, {ball.right});
  const Sighting without = sight({ball.left}, {ball.right}, std::nullopt, {});
  EXPECT_LT(with.point.covariance.trace(), 0.2 * without.point.covariance.trace());
  // A radius read with a tenth of a pixel: 0.5 m / 20 px of it in depth.
  EXPECT_NEAR(std::sqrt(with.point.covariance.trace()), 0.5 * 0.1 / 20, 0.5e-3);
}

}  // namespace
}  // namespace multireach::vision
