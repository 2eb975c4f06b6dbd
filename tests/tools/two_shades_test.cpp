// Targets of two shades, of which one has the learned colours: as a marbled ball.
#include "tests/tools/flat_things.hpp"
#include "vision/stereo_vision.hpp"

namespace multireach {
namespace {

using testing::kFrame;
using testing::level_rig;
using testing::look;
using testing::options_for;
using vision::StereoVision;
using vision::TargetReport;
using Status = vision::TargetTrack::Status;

const cv::Scalar kPale(63, 63, 200);  // of the hue of the red that is learned, with 0.7 of its saturation

/// A pale square plate with a red band below its middle, from 0 to 0.9 of half its side. It has no sphere contour.
testing::Draw banded_plate(double half_side) {
  return [=](cv::Mat& image, const CameraModel& camera, const Eigen::Vector3d& p_C) {
    const Eigen::Vector2d centre = camera.project(p_C);
    const double scale = camera.fx * half_side / p_C.z();
    const auto draw = [&](double top, double bottom, const cv::Scalar& colour) {
      std::vector<cv::Point> corners;
      for (const Eigen::Vector2d& corner : {Eigen::Vector2d(-1, top), Eigen::Vector2d(1, top),
                                            Eigen::Vector2d(1, bottom), Eigen::Vector2d(-1, bottom)}) {
        const Eigen::Vector2d at = centre + scale * corner;
        corners.emplace_back(testing::sixteenths(at.x()), testing::sixteenths(at.y()));
      }
      cv::fillConvexPoly(image, corners, colour, cv::LINE_AA, testing::kBits);
    };
    draw(-1, 1, kPale);
    draw(0, 0.9, testing::kRed);
  };
}

// A plate that is red, and confirmed, until most of it comes into other light. The centre of the band that stays red is
// 0.45 of half a side below that of the plate.
TEST(TwoShades, APlateOfWhichABandIsLeftIsLocatedAsAWhole) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  constexpr double kHalfSide = 0.025;
  constexpr int kRedPairs = 30;
  for (int k = 0; k < 60; ++k) {
    const Eigen::Vector3d centre(-0.18 + 0.006 * k, 0.02, 0.5);
    const testing::Draw draw = k < kRedPairs ? testing::plate(kHalfSide, kHalfSide, 0) : banded_plate(kHalfSide);
    const TargetReport& report = look(vision, rig, k * kFrame, {{draw, centre}});
    if (k < kRedPairs) continue;
    ASSERT_TRUE(vision.targets().front().tracker.identity().confirmed()) << k;
    ASSERT_EQ(report.status, Status::kTracked) << k << ": " << report.reason;
    EXPECT_LT((report.estimate.position - centre).head<2>().norm(), 0.1 * kHalfSide) << k;
  }
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

}  // namespace
}  // namespace multireach
