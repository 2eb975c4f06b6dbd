// A target that enters through the border of the image.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "tests/tools/flat_things.hpp"
#include "tests/tools/folder_room.hpp"

namespace multireach {
namespace {

using vision::StereoVision;
using Status = vision::TargetTrack::Status;

// It moves slowly along the upper border, half outside: the background remembers about half of it.
TEST(EnteringTarget, ASpeckIsNotTakenForABallThatLingersAtTheBorder) {
  const StereoRig rig = level_rig();
  const Room alone(rig, {}), with_speck(rig, {cv::Rect(60, 130, 12, 6)});
  constexpr double kDistance = 0.3, kBorder = -120 / kFocal * kDistance;  // 33 px of radius
  const auto ball = [&](int k) { return Eigen::Vector3d(0.1 - 0.002 * k, kBorder, kDistance); };
  StereoVision vision({options_for(rig)}), only_speck({options_for(rig)});
  int k = 0, told = 0;
  for (; k < 10; ++k) alone.look(k, ball(k), vision);
  for (; k < 25; ++k) {
    with_speck.look(k, ball(k), vision);
    const vision::TargetReport& report = vision.targets().front().report;
    EXPECT_NE(report.status, Status::kTracked) << k;
    told += report.reason ==
            std::string_view("something at the image border is more like the target than what is wholly seen");
    with_speck.look(k, std::nullopt, only_speck);
  }
  EXPECT_GT(told, 0);
  EXPECT_EQ(only_speck.targets().front().report.status, Status::kTracked) << "where nothing is at the border";
  int right = 0;
  for (const int start = k; k < start + 10; ++k) {
    const Eigen::Vector3d inside = ball(k) + Eigen::Vector3d(0, 0.008 * (k - start), 0);
    with_speck.look(k, inside, vision);
    right += is_at(vision.targets().front().report, inside);
  }
  EXPECT_GE(right, 4) << "of the last 5, in which it is wholly inside";
}

// Plates that stand on a corner, of which the border cuts off another one: they have no sphere contour.
TEST(EnteringTarget, ALargeThingIsTrackedWhileTheBorderCutsItOffAndASmallOneIsNot) {
  const StereoRig rig = testing::level_rig();
  const auto tracked = [&](double half_length_px, double half_width_px) {
    constexpr double kDistance = 0.5;
    const double m_per_px = kDistance / testing::kFocal,
                 reach_px = (half_length_px + half_width_px) / std::numbers::sqrt2;
    const double border = (-0.5 - rig.left.cy) * m_per_px;
    const Eigen::Vector3d there(0.05, border + 0.75 * reach_px * m_per_px, kDistance);
    StereoVision vision({testing::options_for(rig)});
    const vision::TargetReport& report = testing::look(
        vision, rig, 0, {{testing::plate(half_length_px * m_per_px, half_width_px * m_per_px, 45), there}});
    if (report.status != Status::kTracked) {
      EXPECT_STREQ(report.reason, "the target is cut off by the image border");
      return false;
    }
    EXPECT_FALSE(vision.targets().front().match.both_by_contour);
    const Eigen::Vector3d error = report.estimate.position - there;
    EXPECT_LT(error.dot(report.estimate.covariance.ldlt().solve(error)), 16.27) << "99.9 % of chi^2";
    return true;
  };
  EXPECT_TRUE(tracked(30, 30));
  EXPECT_FALSE(tracked(8, 3));
  EXPECT_FALSE(tracked(30, 4)) << "large, but not compact";
}

TEST(EnteringTarget, TwoEqualThingsAtTheBorderAreTrackedWithTheirOwnImages) {
  const StereoRig rig = testing::level_rig();
  StereoVision vision({testing::options_for(rig), testing::options_for(rig)});
  constexpr double kDistance = 0.5, kHalfSide = 0.025;
  const double border = -rig.left.cy / testing::kFocal * kDistance, y = border + std::numbers::sqrt2 * 0.75 * kHalfSide;
  const testing::Draw diamond = testing::plate(kHalfSide, kHalfSide, 45);
  const std::array<Eigen::Vector3d, 2> there{Eigen::Vector3d(-0.05, y, kDistance), Eigen::Vector3d(0.06, y, kDistance)};
  testing::look(vision, rig, 0, {{diamond, there[0]}, {diamond, there[1]}});
  for (const Eigen::Vector3d& place : there) {
    EXPECT_TRUE(std::ranges::any_of(vision.targets(), [&](const StereoVision::Target& target) {
      return is_at(target.report, place);
    })) << place.transpose();
  }
}

// Half its sides at the distance of these tests, m, and how far from its middle the border is that cuts off its corner.
constexpr double kHalfPlate = 0.03, kPlateDistance = 0.5, kToBorder = 0.75 * std::numbers::sqrt2 * kHalfPlate;

TEST(EnteringTarget, WhatOnlyOneImageCutsOffIsLocatedAsItsCovarianceSays) {
  const StereoRig rig = testing::level_rig();
  // At the left border of the right image: where it stands in the left one, all of it is seen.
  const double border = (-0.5 - rig.right.cx) / testing::kFocal * kPlateDistance;
  const Eigen::Vector3d in_right(border + kToBorder, 0.02, kPlateDistance), there = rig.X_RL.inverse() * in_right;
  StereoVision vision({testing::options_for(rig)});
  const vision::TargetReport& report =
      testing::look(vision, rig, 0, {{testing::plate(kHalfPlate, kHalfPlate, 45), there}});
  ASSERT_EQ(report.status, Status::kTracked) << report.reason;
  const Eigen::Vector3d error = report.estimate.position - there;
  EXPECT_LT(error.dot(report.estimate.covariance.ldlt().solve(error)), 16.27) << "99.9 % of chi^2";
}

// Of what a known radius belongs to, the border leaves a part, which has another size. No sphere's contour fits it.
TEST(EnteringTarget, APartOfAThingOfKnownSizeIsCutOffAndNotOfAWrongRadius) {
  const StereoRig rig = testing::level_rig();
  const double border = (-0.5 - rig.left.cy) / testing::kFocal * kPlateDistance;
  vision::TrackerOptions options = testing::options_for(rig);
  options.match.radius_m = 2 * kHalfPlate / std::sqrt(std::numbers::pi);  // of a disc of the same area
  const testing::Draw diamond = testing::plate(kHalfPlate, kHalfPlate, 45);
  for (const double middle : {-0.6, -0.4, -0.2, 0.0}) {  // from the border, half its diagonals
    const Eigen::Vector3d there(0.05, border + middle * std::numbers::sqrt2 * kHalfPlate, kPlateDistance);
    StereoVision vision({options});
    const vision::TargetReport& report = testing::look(vision, rig, 0, {{diamond, there}});
    EXPECT_NE(report.status, Status::kTracked) << middle;
    EXPECT_STREQ(report.reason, "the target is cut off by the image border") << middle;
  }
}

// A target that suddenly moves back has bounced. But what the border cuts off may be a part of anything.
TEST(EnteringTarget, NoTargetBouncesIntoWhatTheBorderCutsOff) {
  const StereoRig rig = testing::level_rig();
  const double border = (-0.5 - rig.left.cy) / testing::kFocal * kPlateDistance;
  const testing::Draw diamond = testing::plate(kHalfPlate, kHalfPlate, 45);
  const auto bounces = [&](double y) {
    StereoVision vision({testing::options_for(rig)});
    Eigen::Vector3d there(-0.2, y + 0.02, kPlateDistance);
    int k = 0;
    for (; k < 8; ++k) {
      there.x() += 0.04;
      EXPECT_TRUE(is_at(testing::look(vision, rig, k * testing::kFrame, {{diamond, there}}), there)) << k;
    }
    there += Eigen::Vector3d(-0.03, -0.02, 0);
    return is_at(testing::look(vision, rig, k * testing::kFrame, {{diamond, there}}), there);
  };
  EXPECT_TRUE(bounces(border + 2 * kToBorder));
  EXPECT_FALSE(bounces(border + kToBorder));
}

constexpr double kTopBorder = (-0.5 - 0.5 * testing::kHeight) / testing::kFocal * kPlateDistance;  // m

/// Whether a target is tracked within 2 cm of a place.
bool is_near(const vision::TargetReport& report, const Eigen::Vector3d& place) {
  return report.status == Status::kTracked && (report.estimate.position - place).norm() < 0.02;
}

TEST(EnteringTarget, OfTwoThingsAtTheBorderNeitherIsTakenForOneTarget) {
  const StereoRig rig = testing::level_rig();
  const testing::Draw diamond = testing::plate(kHalfPlate, kHalfPlate, 45),
                      smaller = testing::plate(0.2 * kHalfPlate, 0.2 * kHalfPlate, 45);
  const testing::Thing large{diamond, {-0.05, kTopBorder + kToBorder, kPlateDistance}},
      small{smaller, {0.06, kTopBorder + 0.2 * kToBorder, kPlateDistance}};
  StereoVision alone({testing::options_for(rig)}), both({testing::options_for(rig)});
  EXPECT_TRUE(is_near(testing::look(alone, rig, 0, {large}), large.p_L));
  EXPECT_NE(testing::look(both, rig, 0, {large, small}).status, Status::kTracked);
}

// While the target is hidden, a part of something larger comes into view.
TEST(EnteringTarget, AThingOfAnotherSizeIsNotTakenForAHiddenTarget) {
  const StereoRig rig = testing::level_rig();
  constexpr double kBall = 0.02;
  for (const double known_radius : {0.0, kBall}) {
    vision::TrackerOptions options = testing::options_for(rig);
    options.match.radius_m = known_radius;
    StereoVision vision({options});
    int k = 0;
    for (; k < 30; ++k) {
      const Eigen::Vector3d ball(-0.1 + 0.005 * k, 0.05, kPlateDistance);
      testing::look(vision, rig, k * testing::kFrame, {{testing::disc(kBall), ball}});
      EXPECT_TRUE(k < 3 || is_near(vision.targets().front().report, ball)) << k;
    }
    for (; k < 60; ++k) testing::look(vision, rig, k * testing::kFrame);
    for (; k < 90; ++k) {
      const Eigen::Vector3d other(-0.05, kTopBorder + 2 * kToBorder * (k - 60) / 30, kPlateDistance);
      const auto& report = testing::look(vision, rig, k * testing::kFrame,
                                         {{testing::plate(2 * kHalfPlate, 2 * kHalfPlate, 45), other}});
      EXPECT_NE(report.status, Status::kTracked) << k << ", radius " << known_radius;
    }
  }
}

// What is larger than the target was cannot be it.
TEST(EnteringTarget, AHiddenTargetIsFoundAtTheBorderBesideALargerThing) {
  const StereoRig rig = testing::level_rig();
  StereoVision vision({testing::options_for(rig)});
  const testing::Draw diamond = testing::plate(kHalfPlate, kHalfPlate, 45),
                      larger = testing::plate(2 * kHalfPlate, 2 * kHalfPlate, 45);
  int k = 0;
  for (; k < 30; ++k) {
    const Eigen::Vector3d there(-0.15 + 0.012 * k, 0.02, kPlateDistance);
    testing::look(vision, rig, k * testing::kFrame, {{diamond, there}});
    EXPECT_TRUE(k < 3 || is_near(vision.targets().front().report, there)) << k;
  }
  ASSERT_TRUE(vision.targets().front().tracker.identity().confirmed());
  for (; k < 60; ++k) testing::look(vision, rig, k * testing::kFrame);
  const Eigen::Vector3d back(0.08, kTopBorder + kToBorder, kPlateDistance),
      other(-0.1, kTopBorder + 2 * kToBorder, kPlateDistance);
  const auto& report = testing::look(vision, rig, k * testing::kFrame, {{diamond, back}, {larger, other}});
  EXPECT_TRUE(is_near(report, back)) << report.reason;
}

// What was taken for the target at the border goes out again, by more than what may be hidden of a target.
TEST(EnteringTarget, ABallReplacesWhatTheBorderHasLeftTooLittleOf) {
  const StereoRig rig = testing::level_rig();
  constexpr double kBall = 0.02;
  StereoVision vision({testing::options_for(rig)});
  const testing::Draw diamond = testing::plate(2 * kHalfPlate, 2 * kHalfPlate, 45);
  const double inside = kTopBorder + 2 * kToBorder, outside = kTopBorder + 0.2 * kToBorder;
  int k = 0;
  for (; k < 15; ++k) {
    const double share = k < 5 ? 0 : (k - 5) / 10.0;
    const Eigen::Vector3d there(-0.1, inside + share * (outside - inside), kPlateDistance);
    testing::look(vision, rig, k * testing::kFrame, {{diamond, there}});
    EXPECT_TRUE(k != 3 || is_near(vision.targets().front().report, there)) << "taken for the target at first";
  }
  int right = 0;
  for (const int start = k; k < start + 20; ++k) {
    const Eigen::Vector3d ball(0.0 + 0.005 * (k - start), 0.05, kPlateDistance),
        there(-0.1 + 0.003 * (k % 4), outside, kPlateDistance);
    testing::look(vision, rig, k * testing::kFrame, {{testing::disc(kBall), ball}, {diamond, there}});
    right += is_near(vision.targets().front().report, ball);
  }
  EXPECT_GE(right, 15) << "of 20; a jump takes three matches that confirm it";
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
