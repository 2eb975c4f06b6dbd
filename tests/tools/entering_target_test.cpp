// A target that enters through the border of the image, which starts no track while the border cuts it off.
#include <gtest/gtest.h>

#include "tests/tools/folder_room.hpp"

namespace multireach {
namespace {

using vision::StereoVision;
using Status = vision::TargetTrack::Status;

// It creeps along the upper border, half outside: the background remembers about half of it.
TEST(EnteringTarget, ASpeckIsNotTakenForABallThatLingersAtTheBorder) {
  const StereoRig rig = level_rig();
  const Room alone(rig, {}), with_speck(rig, {cv::Rect(60, 130, 12, 6)});
  constexpr double kDistance = 0.3, kBorder = -120 / kFocal * kDistance;  // 33 px of radius
  const auto ball = [&](int k) { return Eigen::Vector3d(0.1 - 0.002 * k, kBorder, kDistance); };
  StereoVision vision({options_for(rig)}), only_speck({options_for(rig)});
  int k = 0;
  for (; k < 10; ++k) alone.look(k, ball(k), vision);
  for (; k < 25; ++k) {
    with_speck.look(k, ball(k), vision);
    EXPECT_NE(vision.targets().front().report.status, Status::kTracked) << k;
    with_speck.look(k, std::nullopt, only_speck);
  }
  EXPECT_EQ(only_speck.targets().front().report.status, Status::kTracked) << "where nothing is at the border";
  int right = 0;
  for (const int start = k; k < start + 10; ++k) {
    const Eigen::Vector3d inside = ball(k) + Eigen::Vector3d(0, 0.008 * (k - start), 0);
    with_speck.look(k, inside, vision);
    right += is_at(vision.targets().front().report, inside);
  }
  EXPECT_GE(right, 4) << "from where the border does not cut it off";
}

TEST(EnteringTarget, AThingThatStandsAtTheBorderDoesNotKeepABallOut) {
  const StereoRig rig = level_rig();
  const Room room(rig, {cv::Rect(120, 0, 100, 60)});
  StereoVision vision({options_for(rig)});
  int k = 0;
  for (; k < 60; ++k) {
    room.look(k, std::nullopt, vision);
    EXPECT_NE(vision.targets().front().report.status, Status::kTracked) << k;
  }
  int right = 0;
  for (const int start = k; k < start + 10; ++k) {
    const Eigen::Vector3d ball(-0.3 + 0.01 * (k - start), 0.1, 2.2);  // 4.5 px of radius
    room.look(k, ball, vision);
    right += is_at(vision.targets().front().report, ball);
  }
  EXPECT_GE(right, 9) << "of 10";
}

}  // namespace
}  // namespace multireach
