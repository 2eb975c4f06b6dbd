// Targets of unknown size that something covers, and equal things that were covered while the target was seen.
#include <Eigen/Cholesky>
#include <algorithm>

#include "tests/tools/flat_things.hpp"

namespace multireach {
namespace {

using testing::disc;
using testing::kFrame;
using testing::level_rig;
using testing::look;
using testing::options_for;
using testing::plate;
using testing::Thing;
using vision::StereoVision;
using vision::TargetReport;
using Status = vision::TargetTrack::Status;

// An equal plate rests, mostly covered, while the target is followed. The target and the cover are taken away, and the
// whole plate, a part of which is remembered, is taken for the target. When the target comes back, the track returns to
// it: what was remembered while the target was elsewhere still counts.
TEST(OccludedTarget, AnEqualThingThatWasMostlyCoveredIsLeftForTheTarget) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  constexpr int kSeen = 60, kAway = 40, kBack = 60;
  // To and fro.
  const auto target_at = [](int k) {
    const int phase = k % 80;
    return Thing{plate(0.025, 0.025, 0), {-0.15 + 0.006 * std::min(phase, 80 - phase), -0.05, 0.5}};
  };
  const Thing part{plate(0.025, 0.006, 0), {0.12, 0.056, 0.5}}, whole{plate(0.025, 0.025, 0), {0.12, 0.05, 0.5}};
  int k = 0;
  for (; k < kSeen; ++k) look(vision, rig, k * kFrame, {target_at(k), part});
  ASSERT_TRUE(vision.targets().front().tracker.identity().confirmed());
  for (; k < kSeen + kAway / 2; ++k) look(vision, rig, k * kFrame, {part});
  for (; k < kSeen + kAway; ++k) look(vision, rig, k * kFrame, {whole});
  const TargetReport other = vision.targets().front().report;
  ASSERT_EQ(other.status, Status::kTracked) << other.reason;
  int wrong = 0;
  for (; k < kSeen + kAway + kBack; ++k) {
    const Thing target = target_at(k);
    const TargetReport& report = look(vision, rig, k * kFrame, {target, whole});
    wrong += report.status == Status::kTracked && (report.estimate.position - target.p_L).norm() > 0.02;
  }
  EXPECT_LT(wrong, 20) << "of " << kBack << " pairs: two whole searches of every eighth pair";
  EXPECT_EQ(vision.targets().front().report.status, Status::kTracked);
}

// A round piece of a covered disc, as between fingers, has a contour of its own, but not the disc's centre.
TEST(OccludedTarget, ARoundPieceOfItIsUncertain) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  constexpr double kRadius = 0.04;
  const Eigen::Vector3d centre(0, 0, 0.5), piece = centre + Eigen::Vector3d(0.02, 0.01, 0);
  int k = 0;
  for (; k < 60; ++k) look(vision, rig, k * kFrame, {{disc(kRadius), centre}});
  ASSERT_EQ(vision.targets().front().report.status, Status::kTracked);
  ASSERT_TRUE(vision.targets().front().match.both_by_contour);
  const TargetReport& report = look(vision, rig, k * kFrame, {{disc(0.3 * kRadius), piece}});
  ASSERT_EQ(report.status, Status::kTracked) << report.reason;
  ASSERT_TRUE(vision.targets().front().match.both_by_contour);
  const Eigen::Vector2d error = (report.estimate.position - centre).head<2>();
  const Eigen::Matrix2d covariance = report.estimate.covariance.topLeftCorner<2, 2>();
  EXPECT_LT(error.dot(covariance.ldlt().solve(error)), 9.21) << "99 % of chi^2, two degrees of freedom";
}

// A card that turns edge-on is less compact, but nothing else is seen with it: its colour is followed.
TEST(OccludedTarget, ACardThatTurnsIsFollowedIntoOtherLight) {
  const StereoRig rig = level_rig();
  vision::TrackerOptions options = options_for(rig);
  options.colour.fill(vision::model_of({.references = {{200, 40, 40}}, .tolerance = 0.35}));
  StereoVision vision({options});
  constexpr int kFaces = 40, kDrifts = 270;
  int tracked = 0;
  for (int k = 0; k < kFaces + kDrifts; ++k) {
    const double drift = std::clamp((k - kFaces) / static_cast<double>(kDrifts), 0.0, 1.0);
    const Thing card{plate(0.04, k < kFaces ? 0.035 : 0.008, 0), {-0.2 + 0.01 * std::min(k, kFaces), 0, 0.5}};
    cv::Mat left = testing::wall(2), right = testing::wall(3);
    card.draw(left, rig.left, card.p_L);
    card.draw(right, rig.right, rig.X_RL * card.p_L);
    for (cv::Mat* image : {&left, &right})
      cv::multiply(*image, cv::Scalar(1 - 0.5 * drift, 1 - 0.28 * drift, 1), *image);
    vision::DecodedImages images({k * kFrame, k * kFrame, k * kFrame}, left, right);
    ASSERT_EQ(vision.update(images), nullptr);
    tracked += vision.targets().front().report.status == Status::kTracked;
  }
  EXPECT_GT(tracked, kFaces + kDrifts - 10) << vision.targets().front().report.reason;
}

// What fingers leave of a target is not what it looks like: when it is hidden, such a piece elsewhere is not taken for
// it.
TEST(OccludedTarget, AMostlyCoveredTargetIsRememberedAsItWas) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  static constexpr int kSeen = 40, kOccluded = 60, kHidden = 30, kElsewhere = 60;
  const testing::Draw whole = plate(0.025, 0.025, 0), piece = plate(0.012, 0.003, 0);
  const auto target_at = [](int k) { return Eigen::Vector3d(-0.15 + 0.008 * std::min(k, kSeen), 0.05, 0.5); };
  int k = 0;
  for (; k < kSeen; ++k) look(vision, rig, k * kFrame, {Thing{whole, target_at(k)}});
  const StereoVision::Target& target = vision.targets().front();
  ASSERT_TRUE(target.tracker.identity().confirmed());
  for (; k < kSeen + kOccluded; ++k) {
    look(vision, rig, k * kFrame, {Thing{piece, target_at(k)}});
    ASSERT_EQ(target.report.status, Status::kTracked) << k << ' ' << target.report.reason;
  }
  for (; k < kSeen + kOccluded + kHidden; ++k) look(vision, rig, k * kFrame);
  ASSERT_EQ(target.report.status, Status::kLost);
  for (const int begin = k; k < begin + kElsewhere; ++k) {
    const Eigen::Vector3d elsewhere(0.15 - 0.004 * (k - begin), -0.1, 0.5);
    look(vision, rig, k * kFrame, {Thing{piece, elsewhere}});
    ASSERT_EQ(target.report.status, Status::kLost) << k << ' ' << target.report.estimate.position.transpose();
  }
}

}  // namespace
}  // namespace multireach
