// Targets of two shades, of which one has the learned colours: a marbled ball, a ball with a dark side.
#include "tests/tools/flat_things.hpp"
#include "vision/object_detector.hpp"

namespace multireach {
namespace {

using testing::disc;
using testing::kFrame;
using testing::level_rig;
using testing::look;
using testing::options_for;
using vision::StereoVision;
using vision::TargetReport;
using Status = vision::TargetTrack::Status;

const cv::Scalar kPale(63, 63, 200);  // of the hue of the red that is learned, with 0.7 of its saturation

/// A pale disc with a red band below its middle, from 0.1 to 0.6 radii.
testing::Draw banded_disc(double radius) {
  return [=](cv::Mat& image, const CameraModel& camera, const Eigen::Vector3d& p_C) {
    const Eigen::Vector2d centre = camera.project(p_C);
    const double r = camera.fx * radius / p_C.z();
    cv::circle(image, {testing::sixteenths(centre.x()), testing::sixteenths(centre.y())}, testing::sixteenths(r), kPale,
               cv::FILLED, cv::LINE_AA, testing::kBits);
    std::vector<cv::Point> band;
    const auto add = [&](double y, double side) {
      const Eigen::Vector2d corner = centre + r * Eigen::Vector2d(side * std::sqrt(1 - y * y), y);
      band.emplace_back(testing::sixteenths(corner.x()), testing::sixteenths(corner.y()));
    };
    for (double y = 0.1; y < 0.6; y += 0.05) add(y, -1);
    for (double y = 0.6; y > 0.1; y -= 0.05) add(y, 1);
    cv::fillConvexPoly(image, band, testing::kRed, cv::LINE_AA, testing::kBits);
  };
}

// The centre of the band is 0.34 radii below that of the disc.
TEST(TwoShades, ADiscOfWhichABandIsLearnedIsLocatedAsAWhole) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  constexpr double kRadius = 0.04;
  for (int k = 0; k < 60; ++k) {
    const Eigen::Vector3d centre(-0.1 + 0.003 * k, 0.02, 0.5);
    const TargetReport& report = look(vision, rig, k * kFrame, {{banded_disc(kRadius), centre}});
    if (k < 30) continue;  // not confirmed yet
    ASSERT_EQ(report.status, Status::kTracked) << k << ": " << report.reason;
    EXPECT_LT((report.estimate.position - centre).head<2>().norm(), 0.1 * kRadius) << k;
  }
  EXPECT_TRUE(vision.targets().front().tracker.identity().confirmed());
}

// What is pale alone is no target: only a red part makes it one.
TEST(TwoShades, AThingOfTheOtherShadeAloneIsNotSeen) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  const testing::Draw pale = [](cv::Mat& image, const CameraModel& camera, const Eigen::Vector3d& p_C) {
    const Eigen::Vector2d centre = camera.project(p_C);
    cv::circle(image, cv::Point(cvRound(centre.x()), cvRound(centre.y())), 40, kPale, cv::FILLED);
  };
  for (int k = 0; k < 20; ++k) EXPECT_EQ(look(vision, rig, k * kFrame, {{pale, {0, 0, 0.5}}}).status, Status::kLost);
}

// The white balance follows what the learned colours show, not what is added: else the colours would drift to the pale
// shade, and a pale thing would be the target.
TEST(TwoShades, TheOtherShadeIsNotLearned) {
  const StereoRig rig = level_rig();
  vision::ObjectDetector detector(options_for(rig), Side::kLeft);
  const cv::Rect all = detector.search_area();
  for (int k = 0; k < 100; ++k) {
    cv::Mat image = testing::wall(2);
    banded_disc(0.04)(image, rig.left, {0, 0.02, 0.5});
    const vision::View view = detector.measure(image, all, false, vision::Colours::kGrown);
    ASSERT_EQ(view.blobs.size(), 1U);
    ASSERT_GT(view.blobs[0].area, 2 * view.seeds[0].area);
    detector.adapt(view, 0, 1);
  }
  const vision::WhiteBalanceGains& gains = detector.gains();
  EXPECT_NEAR(gains.red, 1, 0.02);
  EXPECT_NEAR(gains.blue, 1, 0.02);
}

}  // namespace
}  // namespace multireach
