// Things that have the target's colours only in part, or not well.
#include "tests/tools/flat_things.hpp"

namespace multireach {
namespace {

using namespace testing;
using vision::StereoVision;
using Status = vision::TargetTrack::Status;

/// A cross, with this colour.
Draw cross(const cv::Scalar& bgr) {
  return [=](cv::Mat& image, const CameraModel& camera, const Eigen::Vector3d& p_C) {
    const Eigen::Vector2d c = camera.project(p_C);
    const int reach = sixteenths(camera.fx * 0.04 / p_C.z()), x = sixteenths(c.x()), y = sixteenths(c.y());
    for (const cv::Point& arm : {cv::Point(reach, 0), cv::Point(0, reach)})
      cv::line(image, cv::Point(x, y) - arm, cv::Point(x, y) + arm, bgr, 9, cv::LINE_AA, kBits);
  };
}

// The reflection of a lamp: with its red channel clipped, it may be of a far more saturated red than it looks.
TEST(OffColour, AReflectionThatMayBeOfAnyWarmColourIsNoTarget) {
  const StereoRig rig = level_rig();
  const Eigen::Vector3d there(0.05, 0.02, 0.5);
  for (const bool red : {true, false}) {
    StereoVision vision({options_for(rig)});
    const Thing thing{cross(red ? kRed : cv::Scalar(130, 150, 255)), there};
    for (int k = 0; k < 5; ++k) look(vision, rig, k * kFrame, {thing});
    const vision::TargetReport& report = vision.targets().front().report;
    if (red) {
      EXPECT_EQ(report.status, Status::kTracked) << report.reason;
    } else {
      EXPECT_EQ(report.status, Status::kLost);
      EXPECT_STREQ(report.reason, "only things whose colours are at the limits of the target's are seen");
    }
  }
}

/// A ball of which a grey panel covers a part, m from its left edge.
Draw covered_ball(double radius, double covered) {
  return [=](cv::Mat& image, const CameraModel& camera, const Eigen::Vector3d& p_C) {
    disc(radius)(image, camera, p_C);
    if (covered <= 0) return;
    const double left = -radius - 0.03, right = covered - radius;
    const cv::Scalar grey(90, 90, 90);
    const Eigen::Vector2d a = camera.project(p_C + Eigen::Vector3d(left, -1.3 * radius, 0)),
                          b = camera.project(p_C + Eigen::Vector3d(right, 1.3 * radius, 0));
    cv::rectangle(image, {sixteenths(a.x()), sixteenths(a.y())}, {sixteenths(b.x()), sixteenths(b.y())}, grey,
                  cv::FILLED, cv::LINE_AA, kBits);
  };
}

// While a target is partly occluded, it corrects the track, and what is seen of it is no background.
TEST(OffColour, WhatIsSeenOfAPartlyOccludedTargetIsNoBackground) {
  constexpr double kRadius = 0.03;
  const StereoRig rig = level_rig();
  vision::TrackerOptions options = options_for(rig);
  options.match.radius_m = kRadius;
  StereoVision vision({options});
  const StereoVision::Target& target = vision.targets().front();
  int k = 0;
  const auto show = [&](double x, double covered) {
    look(vision, rig, k * kFrame, {{covered_ball(kRadius, covered), {x, 0.02, 0.5}}});
    ++k;
  };
  for (int step = 0; step < 40; ++step) show(-0.15 + 0.004 * step, 0);
  ASSERT_TRUE(target.tracker.identity().confirmed());
  int partly = 0;
  for (int step = 0; step < 80; ++step) {
    show(0.01 + 0.004 * std::min(step, 36), 0.9 * kRadius);
    partly += target.report.status == Status::kCoasting && target.report.last_seen_utime == (k - 1) * kFrame;
  }
  ASSERT_GT(partly, 60) << target.report.reason;
  show(0.01 + 0.004 * 36, 0);
  ASSERT_FALSE(target.views[0].appearance.empty());
  EXPECT_LT(target.views[0].appearance.front().background, 0.25);
  EXPECT_EQ(target.report.status, Status::kTracked) << target.report.reason;
}

}  // namespace
}  // namespace multireach
