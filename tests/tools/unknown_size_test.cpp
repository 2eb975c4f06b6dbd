// Objects of unknown size: what was seen of them before counts for a while, and only then.
#include "tests/tools/flat_things.hpp"

namespace multireach {
namespace {

using testing::disc;
using testing::Draw;
using testing::kFrame;
using testing::level_rig;
using testing::look;
using testing::options_for;
using testing::plate;
using vision::StereoVision;
using Status = vision::TargetTrack::Status;

double sigma_of(const vision::TargetReport& report) {
  return std::sqrt(report.estimate.covariance.trace());
}

TEST(UnknownSize, ImagesOfDifferentTimesAreRefused) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  const int64_t pair = 10000000;
  const auto fault = [&](int64_t left, int64_t right) {
    cv::Mat image = testing::wall(2), other = testing::wall(3);
    vision::DecodedImages images({pair, left, right}, image, other);
    vision.restart();
    const char* said = vision.update(images);
    return std::string(said ? said : "");
  };
  const std::string apart = "an image was taken more than 0.2 s before or after the other one, or the time of the pair";
  EXPECT_EQ(fault(pair - 200000, pair), "");
  EXPECT_EQ(fault(pair - 200001, pair), apart);
  EXPECT_EQ(fault(pair - 120000, pair + 120000), apart);
  EXPECT_EQ(fault(pair + 300000, pair + 300000), apart) << "from the time of the pair";
  EXPECT_EQ(fault(0, pair), "") << "not known";
}

TEST(UnknownSize, WhatCoastsGoesOnFromItsState) {
  StereoRig rig = level_rig();
  rig.X_WL.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  StereoVision vision({options_for(rig)}), other({options_for(rig)});
  constexpr int kSeen = 20;
  for (int k = 0; k < kSeen; ++k) look(vision, rig, k * kFrame, {{plate(0.06, 0.02, 25), {0.002 * k, 0.01, 0.45}}});
  ASSERT_EQ(vision.targets().front().report.status, Status::kTracked);
  constexpr int64_t kLast = (kSeen - 1) * kFrame;
  ASSERT_TRUE(other.deserialize(kLast, {vision.serialize(0, kLast)}));
  for (int k = kSeen; k < kSeen + 3; ++k) {
    const vision::TargetReport &live = look(vision, rig, k * kFrame), &resumed = look(other, rig, k * kFrame);
    ASSERT_EQ(live.status, Status::kCoasting);
    EXPECT_TRUE(live.estimate.covariance == resumed.estimate.covariance) << k << ": to the last bit";
    EXPECT_EQ(vision.serialize(0, k * kFrame), other.serialize(0, k * kFrame)) << k;
  }
}

TEST(UnknownSize, ALargerThingThatLeftDoesNotLockOutTheTarget) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)}), fresh({options_for(rig)});
  int64_t utime = 0;
  for (int k = 0; k < 15; ++k, utime += kFrame) look(vision, rig, utime, {{disc(0.42), {0.03 * k, 0, 2.5}}});
  ASSERT_EQ(vision.targets().front().report.status, Status::kTracked);
  for (int k = 0; k < 60; ++k, utime += kFrame) look(vision, rig, utime);
  ASSERT_EQ(vision.targets().front().report.status, Status::kLost);
  StereoVision later = vision;

  const Draw small = plate(0.025, 0.02, 0);
  const Eigen::Vector3d there(0, 0.02, 0.33);
  const double sigma = sigma_of(look(fresh, rig, utime, {{small, there}}));
  const vision::TargetReport& soon = look(vision, rig, utime, {{small, there}});
  ASSERT_EQ(soon.status, Status::kTracked);
  EXPECT_GT(sigma_of(soon), 0.1) << "it may be a small part of the large thing";
  utime += 40'000'000;
  const vision::TargetReport& long_after = look(later, rig, utime, {{small, there}});
  ASSERT_EQ(long_after.status, Status::kTracked);
  EXPECT_NEAR(sigma_of(long_after), sigma, 1e-3 * sigma) << "after half a minute it is something else";
}

double sideways(const vision::TargetReport& report) {
  return std::sqrt(report.estimate.covariance(0, 0));
}

TEST(UnknownSize, IsForgottenWithTimeAlsoByCamerasThatAreSlow) {
  const StereoRig rig = level_rig();
  vision::TrackerOptions options = options_for(rig);
  constexpr int64_t kSlow = 250'000;
  options.track.coast_s = 1;
  StereoVision vision({options});
  int64_t utime = 0;
  const Eigen::Vector3d there(0, 0, 0.5);
  for (int k = 0; k < 20; ++k, utime += kSlow) look(vision, rig, utime, {{plate(0.05, 0.05, 0), there}});
  const double whole = sideways(vision.targets().front().report);
  const Draw half = plate(0.05, 0.025, 0);
  const double at_first = sideways(look(vision, rig, utime, {{half, there}}));
  for (int k = 0; k < 4 * 90; ++k) look(vision, rig, utime += kSlow, {{half, there}});
  const vision::TargetReport& report = vision.targets().front().report;
  ASSERT_EQ(report.status, Status::kTracked);
  EXPECT_GT(at_first, 2 * whole) << "half of it seems to be occluded";
  StereoVision fresh({options});
  EXPECT_LT(sideways(report), 1.2 * sideways(look(fresh, rig, utime, {{half, there}}))) << "after a minute and a half";
}

/// How far the position is off, in standard deviations.
double sigmas_off(const vision::TargetReport& report, const Eigen::Vector3d& truth) {
  const Eigen::Vector3d error = report.estimate.position - truth;
  return std::sqrt(error.dot(report.estimate.covariance.llt().solve(error)));
}

// A larger plate of the colour comes from the right, touches the target for a second and a half, and leaves. For the
// colours, the two are one thing, whose centre is that of both.
TEST(UnknownSize, TheCovarianceAllowsForANeighbourThatTouchesTheTarget) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  constexpr double kHalf = 0.025, kNeighbour = 0.035;
  constexpr int kRests = 40, kTouches = 60, kLeaves = 105, kEnd = 140;
  int together = 0;
  for (int k = 0; k < kEnd; ++k) {
    const Eigen::Vector3d target(-0.006 * std::max(0, kRests - k), 0.02, 0.5);
    const double gap = 0.004 * std::max({0, kTouches - k, k - kLeaves}) - 0.001;
    const testing::Thing neighbour{plate(kNeighbour, kNeighbour, 0),
                                   target + Eigen::Vector3d(kHalf + kNeighbour + gap, 0, 0)};
    std::vector<testing::Thing> things{{plate(kHalf, kHalf, 0), target}};
    if (k > kRests) things.push_back(neighbour);
    const vision::TargetReport& report = look(vision, rig, k * kFrame, things);
    if (report.status != Status::kTracked) continue;
    EXPECT_LT(sigmas_off(report, target), 4) << k << ": " << report.reason;
    together += gap < 0 ? 1 : 0;
  }
  EXPECT_GT(together, 0) << "or else this shows nothing";
}

}  // namespace
}  // namespace multireach
