// Targets that are only looked for in a part of the room.
#include <gtest/gtest.h>

#include <array>
#include <stdexcept>

#include "tests/tools/folder_room.hpp"

namespace multireach {
namespace {

using vision::StereoVision;
using Status = vision::TargetTrack::Status;

TEST(SearchRegionTracking, OfTwoEqualBallsTheOneInItIsTracked) {
  const StereoRig rig = level_rig();
  const Room room(rig, {});
  vision::TrackerOptions options = options_with_radius(rig);
  const Eigen::Vector3d meant(0.12, -0.02, 1.2), other(-0.15, 0.03, 1.25), away(0.12, 0.25, 1.2);
  options.search_region = vision::SearchRegion(meant.array() - 0.1, meant.array() + 0.1);
  StereoVision vision({options});
  for (int k = 0; k < 30; ++k) {
    room.look(k, meant, vision, {other});
    EXPECT_TRUE(is_at(vision.targets().front().report, meant)) << k << vision.targets().front().report.reason;
  }
  // It leaves the region, and can still be seen.
  for (int k = 30; k < 60; ++k) {
    room.look(k, away, vision, {other});
    EXPECT_NE(vision.targets().front().report.status, Status::kTracked) << k;
  }
  EXPECT_EQ(vision.targets().front().report.status, Status::kLost);
}

TEST(SearchRegionTracking, ABallBeyondItIsNotTheTarget) {
  const StereoRig rig = level_rig();
  const Room room(rig, {});
  const Eigen::Vector3d ball(0.12, -0.02, 1.5);
  vision::TrackerOptions options = options_with_radius(rig);
  options.search_region = vision::SearchRegion(Eigen::Vector3d(-0.3, -0.2, 1.0), Eigen::Vector3d(0.3, 0.2, 1.4));
  StereoVision vision({options});
  for (int k = 0; k < 20; ++k) {
    room.look(k, ball, vision);
    EXPECT_EQ(vision.targets().front().report.status, Status::kLost) << k;
  }
  EXPECT_STREQ(vision.targets().front().report.reason,
               "objects of the target's colour are seen only outside search_region_m");
}

/// Images of which only the pixels of the search areas are valid.
TEST(SearchRegionTracking, OnlyItsPixelsAreRead) {
  const StereoRig rig = level_rig();
  const BallRenderer left({.ball_radius_m = 0.033, .wall_distance_m = 3}, rig.left, rig.X_WL, rig.X_WL);
  const BallRenderer right({.ball_radius_m = 0.033, .wall_distance_m = 3}, rig.right, rig.X_RL.inverse(), rig.X_WL);
  const Eigen::Vector3d ball(0.12, -0.02, 1.2);
  for (const double right_end : {0.13, 0.16, 0.2, 0.3}) {  // at the first two, the area's border cuts the ball's image
    vision::TrackerOptions options = options_with_radius(rig);
    options.search_region =
        vision::SearchRegion(Eigen::Vector3d(0.1, -0.1, 1.15), Eigen::Vector3d(right_end, 0.1, 1.25));
    std::array<cv::Mat, 2> images{left.render(ball, 0), right.render(ball, 1)};
    vision::StereoTracker tracker(options);
    const vision::StereoMatch all = tracker.find(images[0], images[1]).match;
    for (const Side side : {Side::kLeft, Side::kRight}) {
      cv::Mat only(images[index(side)].size(), CV_8UC3, cv::Scalar(110, 40, 220));  // the target's colour
      const cv::Rect area = tracker.search_area(side);
      images[index(side)](area).copyTo(only(area));
      images[index(side)] = only;
    }
    const vision::StereoMatch again = tracker.find(images[0], images[1]).match;
    EXPECT_EQ(all.status, again.status);
    EXPECT_EQ(all.point.p_W, again.point.p_W) << right_end;
  }
}

TEST(SearchRegionTracking, OneThatNoCameraSeesIsRefused) {
  vision::TrackerOptions options = options_for(level_rig());
  options.search_region = vision::SearchRegion(Eigen::Vector3d(0, 0, -2), Eigen::Vector3d(1, 1, -1));
  EXPECT_THROW(vision::StereoTracker{options}, std::invalid_argument);
}

}  // namespace
}  // namespace multireach
