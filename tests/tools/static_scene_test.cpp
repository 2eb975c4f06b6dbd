// Things of the target's colour that stand still, and the target that moves among them.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/tools/folder_room.hpp"

namespace multireach {
namespace {

using vision::StereoVision;
using Status = vision::TargetTrack::Status;

TEST(StaticScene, TheMovingBallWinsAndThingsOfItsColourStayBackground) {
  const StereoRig rig = level_rig();
  const Room room(rig);
  StereoVision vision({options_for(rig)});
  int k = 0;
  for (; k < 90; ++k) room.look(k, std::nullopt, vision);
  for (const double gain : gains_of(vision, k * kFrame)) EXPECT_EQ(gain, 1) << "folders must not change the colour";

  int answers = 0, wrong = 0;
  for (int start = k; k < start + 40; ++k) {
    const double t = (k - start) / 30.0;
    const Eigen::Vector3d ball(0.1 + 0.3 * t, 0.2 - 1.4 * t + 0.5 * 2 * t * t, 1.5);
    room.look(k, ball, vision);
    const vision::TargetReport& report = vision.targets().front().report;
    if (k < start + 4 || report.status != Status::kTracked) continue;
    ++answers;
    wrong += (report.estimate.position - ball).norm() > 0.05;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(answers, 34) << "of 36";

  // The ball has left: the folders were there while the ball was elsewhere.
  for (int start = k; k < start + 150; ++k) {
    room.look(k, std::nullopt, vision);
    EXPECT_NE(vision.targets().front().report.status, Status::kTracked) << k;
  }
  EXPECT_STREQ(vision.targets().front().report.reason, "only things that stood there before have this colour");
  for (const double gain : gains_of(vision, k * kFrame)) EXPECT_NEAR(gain, 1, 0.1);

  int again = 0;
  for (int start = k; k < start + 20; ++k) {
    const Eigen::Vector3d ball(-0.2 + 0.02 * (k - start), -0.2, 1.4);
    room.look(k, ball, vision);
    const vision::TargetReport& report = vision.targets().front().report;
    again += report.status == Status::kTracked && (report.estimate.position - ball).norm() < 0.05;
  }
  EXPECT_GE(again, 19) << "of 20: it is acquired again at once";
}

TEST(StaticScene, ASpeckIsNotTakenForABallWhoseImagesAreOfDifferentTimes) {
  const StereoRig rig = level_rig();
  const Room room(rig, {cv::Rect(60, 130, 9, 8)});
  const Eigen::Vector3d ball(0.1, 0.05, 0.7), later = ball + Eigen::Vector3d(0, 0.03, 0);  // 14 px of radius, 13 px
  StereoVision vision({options_for(rig)}), alone({options_for(rig)});
  for (int k = 0; k < 5; ++k) {
    room.look_twice(k, ball, later, vision);
    EXPECT_NE(vision.targets().front().report.status, Status::kTracked) << k;
    EXPECT_STREQ(vision.targets().front().report.reason,
                 "the contours agree in size, but violate the epipolar constraint");
    room.look(k, std::nullopt, alone);
  }
  EXPECT_EQ(alone.targets().front().report.status, Status::kTracked) << "the speck, where nothing outdoes it";
}

TEST(StaticScene, AStandingBallIsTrackedAlthoughFewImagesShowItsContour) {
  const StereoRig rig = level_rig();
  const Eigen::Vector3d ball(0, 0, 0.6);  // 16 px of radius
  const Room alone(rig, {}), with_bar(rig, {cv::Rect(130, 110, 60, 20)}, ball.z());
  StereoVision vision({options_for(rig)});
  const vision::StereoTracker& tracker = vision.targets().front().tracker;
  int k = 0;
  for (; k < 20; ++k) with_bar.look(k, ball, vision);
  EXPECT_FALSE(tracker.identity().confirmed()) << "the bar hides the contour";
  for (; k < 24; ++k) alone.look(k, ball, vision);
  for (; k < 60; ++k) {
    with_bar.look(k, ball, vision);
    EXPECT_EQ(vision.targets().front().report.status, Status::kTracked) << k;
  }
}

TEST(StaticScene, WhereAKnownBallWasFoundAgainIsNoBackgroundOnceItIsBeyondDoubt) {
  const StereoRig rig = level_rig();
  const Room room(rig, {});
  StereoVision vision({options_for(rig)});
  const auto background = [&](size_t side) {
    const vision::View& view = vision.targets().front().views[side];
    return view.appearance.empty() ? -1 : view.appearance.front().background;
  };
  int k = 0;
  for (; k < 40; ++k) room.look(k, Eigen::Vector3d(-0.2 + 0.005 * k, 0, 0.6), vision);
  EXPECT_TRUE(vision.targets().front().tracker.identity().confirmed());
  for (; k < 90; ++k) room.look(k, std::nullopt, vision);
  EXPECT_EQ(vision.targets().front().report.status, Status::kLost);
  // The left image's border cuts it off at first, so that it is not located.
  for (; k < 100; ++k) {
    room.look(k, Eigen::Vector3d(0.326, 0, 0.6), vision);
    EXPECT_NE(vision.targets().front().report.status, Status::kTracked) << k;
  }
  EXPECT_GT(background(1), 0.2);
  for (; k < 104; ++k) room.look(k, Eigen::Vector3d(0.296, 0, 0.6), vision);
  EXPECT_EQ(vision.targets().front().report.status, Status::kTracked);
  EXPECT_GT(background(0), 0.2) << "it may be another ball that rested here";
  for (; k < 410; ++k) room.look(k, Eigen::Vector3d(0.296, 0, 0.6), vision);
  EXPECT_FALSE(vision.targets().front().tracker.identity().doubtful(k * kFrame));
  EXPECT_EQ(background(0), 0);
  EXPECT_EQ(background(1), 0);
}

TEST(StaticScene, AMovingBallReplacesAThingThatOnlySeemsToMove) {
  const StereoRig rig = level_rig();
  const auto hook = [&](int x) { return Room(rig, {cv::Rect(x, 130, 24, 5), cv::Rect(x, 130, 5, 20)}); };
  const std::array<Room, 2> rooms{hook(60), hook(65)};
  StereoVision vision({options_for(rig)});
  int k = 0;
  for (; k < 60; ++k) rooms[k / 3 % 2].look(k, std::nullopt, vision);
  EXPECT_EQ(vision.targets().front().report.status, Status::kTracked) << "the hook, while there is nothing else";
  EXPECT_FALSE(vision.targets().front().tracker.identity().stands_still());
  int right = 0;
  for (int start = k; k < start + 30; ++k) {
    const Eigen::Vector3d ball(0.3 - 0.01 * (k - start), -0.1, 1);
    rooms[k / 3 % 2].look(k, ball, vision);
    const vision::TargetReport& report = vision.targets().front().report;
    right += report.status == Status::kTracked && (report.estimate.position - ball).norm() < 0.05;
  }
  EXPECT_GE(right, 26) << "of 30: three matches confirm a jump";
}

TEST(StaticScene, WhatIsSeenWithTheTargetDoesNotChangeItsColour) {
  const StereoRig rig = level_rig();
  const Eigen::Vector3d ball(0, 0, 0.6);
  const Room alone(rig, {}), with_bar(rig, {cv::Rect(170, 114, 70, 12)}, ball.z());
  StereoVision vision({options_for(rig)});
  int k = 0;
  for (; k < 20; ++k) alone.look(k, ball, vision);
  const std::vector<double> before = gains_of(vision, k * kFrame);
  for (; k < 50; ++k) with_bar.look(k, ball, vision);
  const std::vector<double> after = gains_of(vision, k * kFrame);
  for (size_t n = 0; n < before.size(); ++n) EXPECT_NEAR(after[n], before[n], 0.005) << n;
}

TEST(StaticScene, AThingThatStandsStillAloneIsTracked) {
  const StereoRig rig = level_rig();
  const Room room(rig, {kFolders.front()});
  StereoVision vision({options_for(rig)});
  int tracked = 0;
  for (int k = 0; k < 120; ++k) {
    room.look(k, std::nullopt, vision);
    tracked += vision.targets().front().report.status == Status::kTracked;
  }
  EXPECT_GE(tracked, 115) << "of 120: nothing else can be meant";
}

TEST(StaticScene, OfTwoThingsThatLookLikeOneEachMayBeTheTarget) {
  const StereoRig rig = level_rig();
  const std::array<cv::Rect, 2> folders{cv::Rect(60, 100, 26, 52), cv::Rect(89, 100, 26, 52)};
  const Room room(rig, {folders[0], folders[1]});
  StereoVision vision({options_for(rig)});
  for (int k = 0; k < 60; ++k) room.look(k, std::nullopt, vision);
  const vision::StereoVision::Target& target = vision.targets().front();
  ASSERT_EQ(target.report.status, Status::kTracked) << target.report.reason;
  ASSERT_EQ(target.views[0].blobs.size(), 1U) << "or this test shows nothing";
  constexpr double kDepth = kFocal * kBaseline / 14;  // cvRound(kFocal * kBaseline / 2.5) pixels of disparity
  for (const cv::Rect& folder : folders) {
    const double x = folder.x + 0.5 * (folder.width - 1) - 160, y = folder.y + 0.5 * (folder.height - 1) - 120;
    const Eigen::Vector3d apart = target.report.estimate.position - kDepth / kFocal * Eigen::Vector3d(x, y, kFocal);
    EXPECT_GT(apart.norm(), 0.1);
    EXPECT_LT(apart.dot(target.report.estimate.covariance.ldlt().solve(apart)), 9) << "three standard deviations";
  }
}

// A plate is pushed before a folder that stands still, until it hides two thirds of it. The size of a folder is not
// known, so what is seen is still taken for all of it, but it was larger before.
TEST(StaticScene, WhatIsGraduallyHiddenIsUncertain) {
  const StereoRig rig = level_rig();
  const cv::Rect folder(60, 100, 40, 60);
  vision::TrackerOptions options = options_for(rig);
  options.track.coast_sigma_m = 1;  // far away for the rig
  StereoVision vision({options});
  constexpr double kDepth = kFocal * kBaseline / 14;  // cvRound(kFocal * kBaseline / 2.5) pixels of disparity
  const Eigen::Vector3d there =
      kDepth / kFocal *
      Eigen::Vector3d(folder.x + 0.5 * (folder.width - 1) - 160, folder.y + 0.5 * (folder.height - 1) - 120, kFocal);
  double farthest = 0;
  for (int k = 0; k < 90; ++k) {
    const int hidden = std::clamp(k - 40, 0, 40);  // rows
    const Room room(rig, {cv::Rect(folder.x, folder.y, folder.width, folder.height - hidden)});
    room.look(k, std::nullopt, vision);
    const vision::TargetReport& report = vision.targets().front().report;
    if (report.status != Status::kTracked) continue;
    const Eigen::Vector3d apart = report.estimate.position - there;
    farthest = std::max(farthest, apart.norm());
    EXPECT_LT(apart.dot(report.estimate.covariance.ldlt().solve(apart)), 9) << k << ": three standard deviations";
  }
  EXPECT_GT(farthest, 0.1) << "or this test shows nothing";
  Room(rig, {}).look(90, std::nullopt, vision);
  const vision::TargetReport& report = vision.targets().front().report;
  ASSERT_EQ(report.status, Status::kCoasting);
  const Eigen::Vector3d apart = report.estimate.position - there;
  EXPECT_LT(apart.dot(report.estimate.covariance.ldlt().solve(apart)), 9) << "all of it is hidden";
}

TEST(StaticScene, ALargerThingIsNotFollowedBesideABallThatMovesLater) {
  const StereoRig rig = level_rig();
  const Room room(rig, {cv::Rect(60, 120, 34, 80)});  // five times the area of the ball
  StereoVision vision({options_for(rig)});
  Eigen::Vector3d ball(0.15, 0, 1.5);
  int right = 0;
  for (int k = 0; k < 120; ++k) {
    const bool moves = k >= 60;
    if (moves) ball += Eigen::Vector3d(0, k % 40 < 20 ? 0.01 : -0.01, 0);  // 0.3 m/s, to and fro
    room.look(k, ball, vision);
    const vision::TargetReport& report = vision.targets().front().report;
    EXPECT_TRUE(report.status != Status::kTracked || is_at(report, ball)) << k << ": the thing is followed";
    if (k >= 90) right += is_at(report, ball);
  }
  EXPECT_EQ(right, 30) << "within a second of moving";
}

TEST(StaticScene, TwoEqualBallsAreAmbiguousUntilOneMoves) {
  const StereoRig rig = level_rig();
  const Room room(rig, {});
  StereoVision vision({options_with_radius(rig)});
  Eigen::Vector3d moving(0.12, -0.02, 1.2);
  const Eigen::Vector3d resting(-0.15, 0.03, 1.25);
  for (int k = 0; k < 10; ++k) {
    room.look(k, moving, vision, {resting});
    const StereoVision::Target& target = vision.targets().front();
    EXPECT_TRUE(target.report.ambiguous) << k << target.report.reason;
    EXPECT_NE(target.report.status, Status::kTracked);
    ASSERT_GE(target.candidates.size(), 2U);
    for (const Eigen::Vector3d& place : {moving, resting}) {
      const auto near = [&](const vision::Candidate& c) { return (c.match.point.p_W - place).norm() < 0.01; };
      EXPECT_EQ(std::count_if(target.candidates.begin(), target.candidates.begin() + 2, near), 1);
    }
  }
  int right = 0;
  for (int k = 10; k < 70; ++k) {
    moving += Eigen::Vector3d(0, k % 40 < 20 ? 0.01 : -0.01, 0);
    room.look(k, moving, vision, {resting});
    const vision::TargetReport& report = vision.targets().front().report;
    EXPECT_FALSE(is_at(report, resting)) << k;
    if (k >= 40) right += is_at(report, moving);
  }
  EXPECT_EQ(right, 30) << "within a second of moving";
}

TEST(StaticScene, ATrackedBallKeepsItsNameWhileAnEqualOneAppearsAndPasses) {
  const StereoRig rig = level_rig();
  const Room room(rig, {});
  StereoVision vision({options_with_radius(rig)});
  int right = 0, ambiguous = 0;
  for (int k = 0; k < 90; ++k) {
    const Eigen::Vector3d target(-0.2 + 0.004 * k, -0.04, 1.2);
    std::vector<Eigen::Vector3d> others;
    if (k >= 20) others.emplace_back(0.35 - 0.008 * (k - 20), 0.05, 1.2);  // passes at a distance of 1.4 diameters
    room.look(k, target, vision, others);
    const vision::TargetReport& report = vision.targets().front().report;
    right += is_at(report, target);
    ambiguous += report.ambiguous;
  }
  EXPECT_EQ(right, 90);
  EXPECT_EQ(ambiguous, 0);
}

TEST(StaticScene, AHiddenBallIsNotReplacedByAnEqualOneThatRestsBesideIt) {
  const StereoRig rig = level_rig();
  const Room room(rig, {});
  const Eigen::Vector3d resting(0.1, 0.1, 1.2);
  for (const bool known : {true, false}) {
    for (const int missing : {0, 1, 2, 5, 12, 45}) {  // pairs, as it disappears; from 15 on the target is lost at once
      StereoVision vision({known ? options_with_radius(rig) : options_for(rig)});
      int k = 0, right = 0;
      for (; k < 80; ++k) {
        const Eigen::Vector3d target(-0.2 + 0.003 * k, -0.04, 1.2);
        std::vector<Eigen::Vector3d> others;
        if (k >= 20) others.push_back(resting);
        room.look(k, target, vision, others);
        right += is_at(vision.targets().front().report, target);
      }
      EXPECT_EQ(right, 80) << known;
      k += missing;
      for (const int end = k + 60; k < end; ++k) {
        room.look(k, std::nullopt, vision, {resting});
        EXPECT_NE(vision.targets().front().report.status, Status::kTracked) << known << " " << missing << " " << k;
      }
    }
  }
}

TEST(StaticScene, ABallThatRestsBeforeAnEqualOneIsFoundAgainAfterAnUnusablePair) {
  const StereoRig rig = level_rig();
  const Room room(rig, {});
  const Eigen::Vector3d equal(0.15, -0.06, 1.5), stop(0.1, -0.04, 1.0);  // on one line of sight of the left camera
  for (const bool known : {true, false}) {
    StereoVision vision({known ? options_with_radius(rig) : options_for(rig)});
    const vision::TargetReport& report = vision.targets().front().report;
    int k = 0;
    const Eigen::Vector3d begin(-0.2, 0.12, 1.0), turn(-0.02, 0.12, 1.0);
    for (; k < 60; ++k) {
      std::vector<Eigen::Vector3d> others;
      if (k >= 20) others.push_back(equal);
      room.look(k, begin + k / 60.0 * (turn - begin), vision, others);
    }
    for (; k < 90; ++k) room.look(k, turn + (k - 59) / 30.0 * (stop - turn), vision, {equal});
    for (; k < 120; ++k) room.look(k, stop, vision, {equal});
    ASSERT_TRUE(is_at(report, stop)) << report.reason;
    const cv::Mat grey(240, 320, CV_8UC3, cv::Scalar::all(128));
    vision::DecodedImages same({k * kFrame, k * kFrame, k * kFrame}, grey, grey);
    EXPECT_STREQ(vision.update(same), "the left and the right image are the same");
    ++k;
    for (const int end = k + 30; k < end; ++k) {
      room.look(k, stop, vision, {equal});
      EXPECT_TRUE(is_at(report, stop)) << known << " " << k << ": " << report.reason;
    }
  }
}

// Every eighth pair the whole image is searched, also for background: it must not become background where a jump waits
// for the matches that confirm it.
TEST(StaticScene, ABallThatJumpsIsFoundWhicheverPairLooksForBackground) {
  const StereoRig rig = level_rig();
  const Room room(rig, {});
  for (const double distance : {0.8, 2.0}) {
    for (int pairs = 60; pairs < 69; ++pairs) {
      StereoVision vision({options_for(rig)});
      const vision::TargetReport& report = vision.targets().front().report;
      int k = 0;
      for (; k < pairs; ++k) room.look(k, Eigen::Vector3d(-0.2 + 0.005 * k, -0.05 * distance, distance), vision);
      ASSERT_EQ(report.status, Status::kTracked);
      const Eigen::Vector3d there(-0.1 * distance, 0.1 * distance, 0.9 * distance);
      int found = 0;
      for (const int end = k + 33; k < end; ++k) {
        room.look(k, there, vision);
        found += report.status == Status::kTracked && (report.estimate.position - there).norm() < 0.05;
      }
      EXPECT_GE(found, 30) << "of 33, from pair " << pairs << " on, at " << distance << " m: " << report.reason;
    }
  }
}

/// Haze, white light or another place in a room changes the saturation of a ball, here to two thirds.
TEST(StaticScene, AConfirmedBallIsFoundAgainInLightThatItsColourWasNotLearnedIn) {
  const StereoRig rig = level_rig();
  const Rgb learned{220, 40, 110}, hazy{192, 66, 115};
  const SceneOptions scene{.ball_radius_m = 0.033, .wall_distance_m = 3, .distractors = 0};
  SceneOptions other = scene;
  other.ball_colour = hazy;
  const BallRenderer usual_left(scene, rig.left, rig.X_WL, rig.X_WL), hazy_left(other, rig.left, rig.X_WL, rig.X_WL);
  const BallRenderer usual_right(scene, rig.right, rig.X_RL.inverse(), rig.X_WL);
  const BallRenderer hazy_right(other, rig.right, rig.X_RL.inverse(), rig.X_WL);
  for (const bool confirmed : {true, false}) {
    vision::TrackerOptions options = options_with_radius(rig);
    options.colour.fill(vision::model_of({.references = {learned}, .tolerance = 0.3}));
    StereoVision vision({options});
    int found = 0, long_after = 0;
    for (int k = confirmed ? 0 : 30; k < 100; ++k) {
      const Eigen::Vector3d ball(-0.1 + 0.004 * k, 0.02, 1.2);
      const bool haze = k >= 30;
      const auto stream = static_cast<uint64_t>(2 * k);
      const cv::Mat left = (haze ? hazy_left : usual_left).render(ball, stream);
      const cv::Mat right = (haze ? hazy_right : usual_right).render(ball, stream + 1);
      const int64_t utime = k * kFrame;
      vision::DecodedImages images({utime, utime, utime}, left, right);
      ASSERT_EQ(vision.update(images), nullptr);
      if (haze && k < 85) found += is_at(vision.targets().front().report, ball);
      if (k > 92) long_after += is_at(vision.targets().front().report, ball);
    }
    EXPECT_EQ(found, confirmed ? 55 : 0) << (confirmed ? "it is expected there" : "anything could have this colour");
    EXPECT_EQ(long_after, 0) << "two seconds after the last match by the learned colours";
    for (const double gain : gains_of(vision, 99 * kFrame)) EXPECT_NEAR(gain, 1, 0.1) << "its colour is not learned";
  }
}

TEST(StaticScene, GoesOnFromItsState) {
  const StereoRig rig = level_rig();
  const Room room(rig);
  StereoVision vision({options_for(rig)});
  for (int k = 0; k < 80; ++k) {
    const int64_t before = (k - 1) * kFrame;
    std::optional<StereoVision> other;
    if (k > 0) {
      const std::vector<double> state = vision.serialize(0, before);
      other.emplace(std::vector{options_for(rig)});
      ASSERT_TRUE(other->deserialize(before, {state}));
      std::vector<double> damaged = state;
      damaged[vision::TargetTrack({}).serialize().size() + 5] = 0.5;  // a cell of the background, which comes next
      EXPECT_FALSE(StereoVision({options_for(rig)}).deserialize(before, {damaged}));
    }
    std::optional<Eigen::Vector3d> ball;
    if (k > 30 && k < 60) ball = Eigen::Vector3d(0.1, 0.01 * (k - 45), 1.5);
    room.look(k, ball, vision);
    if (!other) continue;
    room.look(k, ball, *other);
    EXPECT_EQ(vision.serialize(0, k * kFrame), other->serialize(0, k * kFrame)) << k;
  }
}

}  // namespace
}  // namespace multireach
