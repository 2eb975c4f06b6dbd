// A target of unknown size that was hidden, and other things of its colour that are seen meanwhile.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "tests/tools/flat_things.hpp"

namespace multireach {
namespace {

using testing::kFrame;
using testing::level_rig;
using testing::look;
using testing::options_for;
using testing::plate;
using testing::Thing;
using vision::StereoVision;
using vision::TargetReport;
using Status = vision::TargetTrack::Status;

constexpr int kConfirm = 40, kHide = 30;  // pairs

/// A square plate that moves to the right.
Thing target_at(int k) {
  return {plate(0.025, 0.025, 0), {-0.15 + 0.008 * k, 0.05, 0.5}};
}

double distance(const TargetReport& report, const Thing& thing) {
  return (report.estimate.position - thing.p_L).norm();
}

/// Tracks the target until it is confirmed, then hides it. Returns the number of the next pair.
int see_and_hide(StereoVision& vision, const StereoRig& rig) {
  for (int k = 0; k < kConfirm; ++k) look(vision, rig, k * kFrame, {target_at(k)});
  EXPECT_EQ(vision.targets().front().report.status, Status::kTracked);
  EXPECT_TRUE(vision.targets().front().tracker.identity().confirmed());
  for (int k = kConfirm; k < kConfirm + kHide; ++k) look(vision, rig, k * kFrame);
  EXPECT_EQ(vision.targets().front().report.status, Status::kLost);
  return kConfirm + kHide;
}

TEST(FoundAgain, ASpeckIsNotTakenForTheTargetForTenSeconds) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)}), fresh({options_for(rig)});
  int k = see_and_hide(vision, rig);
  // 13 x 7 pixels; it moves, so that it does not become background.
  const auto speck_at = [](int at) { return Thing{plate(0.0065, 0.0035, 0), {0.15 - 0.002 * (at % 100), -0.1, 0.5}}; };
  const TargetReport& alone = look(fresh, rig, k * kFrame, {speck_at(k)});
  ASSERT_EQ(alone.status, Status::kTracked) << "where nothing else was seen, it may be the target: " << alone.reason;
  for (; k < kConfirm + 290; ++k) {
    const TargetReport& report = look(vision, rig, k * kFrame, {speck_at(k)});
    ASSERT_EQ(report.status, Status::kLost) << k << ' ' << report.estimate.position.transpose();
    ASSERT_STREQ(report.reason, "only things of another size, or much more ragged, than the target are seen");
  }
  StereoVision sees_it = vision;
  const Thing target{plate(0.025, 0.025, 0), {-0.1, 0.05, 0.5}};
  const TargetReport& again = look(sees_it, rig, k * kFrame, {speck_at(k), target});
  EXPECT_EQ(again.status, Status::kTracked);
  EXPECT_LT(distance(again, target), 0.01);
  for (; k < kConfirm + 310; ++k) look(vision, rig, k * kFrame, {speck_at(k)});
  EXPECT_EQ(vision.targets().front().report.status, Status::kTracked) << "the target is forgotten";
}

/// A long thing that moves down: about as large as the target, but less compact.
Thing strip_at(int k) {
  return {plate(0.06, 0.008, 0), {0.12, -0.2 + 0.004 * k, 0.5}};
}

/// Hides the target while another thing moves down, which is taken for it. When the target comes back, beside that
/// thing, the track must return to it; and from the state of each pair, it must go on in the same way.
void expect_left_for_target(const testing::Draw& other) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  const auto other_at = [&](int k) { return Thing{other, {0.12, -0.2 + 0.004 * k, 0.5}}; };
  const int hidden = see_and_hide(vision, rig);
  int k = 0;
  for (; k < 40; ++k) look(vision, rig, (hidden + k) * kFrame, {other_at(k)});
  const TargetReport& report = vision.targets().front().report;
  ASSERT_EQ(report.status, Status::kTracked);
  ASSERT_LT(distance(report, other_at(k - 1)), 0.02);
  ASSERT_TRUE(vision.targets().front().tracker.identity().confirmed()) << "it moves";
  // Every eighth pair looks at the whole images, then three in succession must agree.
  constexpr int kNotices = 8 + 2;
  Thing target = target_at(0);
  for (const int until = k + kNotices; k < until; ++k) {
    const int64_t before = (hidden + k - 1) * kFrame, now = (hidden + k) * kFrame;
    StereoVision resumed({options_for(rig)});
    ASSERT_TRUE(resumed.deserialize(before, {vision.serialize(0, before)}));
    target.p_L.y() = 0.1 - 0.002 * k;
    look(vision, rig, now, {other_at(k), target});
    look(resumed, rig, now, {other_at(k), target});
    const StereoVision::Target& after = vision.targets().front();
    if (after.match.status == vision::StereoMatch::Status::kOutsidePredictionGate) {
      EXPECT_TRUE(std::ranges::none_of(after.candidates, &vision::Candidate::chosen)) << "it is not taken yet";
    }
    EXPECT_EQ(vision.serialize(0, now), resumed.serialize(0, now)) << k << ": goes on from its state";
  }
  for (const int until = k + 20; k < until; ++k) {
    target.p_L.y() = 0.1 - 0.002 * k;
    look(vision, rig, (hidden + k) * kFrame, {other_at(k), target});
    ASSERT_EQ(report.status, Status::kTracked) << k << ' ' << report.reason;
    EXPECT_LT(distance(report, target), 0.01) << k;
  }
}

TEST(FoundAgain, AThingThatWasTakenForTheHiddenTargetIsLeftForIt) {
  expect_left_for_target(plate(0.06, 0.008, 0));
}

// Of the target's area, in a shape of 4:3: a single pair is no strong evidence against it, three in succession are.
TEST(FoundAgain, AThingThatIsALittleLessLikeTheTargetIsLeftForIt) {
  expect_left_for_target(plate(0.0285, 0.022, 0));
}

TEST(FoundAgain, AThingThatWasTakenForOneOfTwoTargetsThatLookAlikeIsLeftForIt) {
  const StereoRig rig = level_rig();
  const vision::TrackerOptions options = options_for(rig);
  StereoVision vision({options, options});
  const auto second_at = [](int at) { return Thing{plate(0.025, 0.025, 0), {0.15 * std::cos(0.05 * at), 0.15, 0.5}}; };
  int k = 0;
  for (; k < kConfirm; ++k) look(vision, rig, k * kFrame, {target_at(k), second_at(k)});
  const size_t first = distance(vision.targets()[0].report, target_at(k - 1)) < 0.01 ? 0 : 1;
  const TargetReport& report = vision.targets()[first].report;
  ASSERT_LT(distance(report, target_at(k - 1)), 0.01);
  const int hidden = kConfirm + kHide;
  for (; k < hidden; ++k) look(vision, rig, k * kFrame, {second_at(k)});
  for (; k < hidden + 40; ++k) look(vision, rig, k * kFrame, {second_at(k), strip_at(k - hidden)});
  ASSERT_EQ(report.status, Status::kTracked);
  ASSERT_LT(distance(report, strip_at(k - 1 - hidden)), 0.02);
  Thing target = target_at(0);
  for (const int until = k + 30; k < until; ++k) {
    target.p_L.y() = -0.05 - 0.002 * (k - hidden);
    look(vision, rig, k * kFrame, {second_at(k), strip_at(k - hidden), target});
  }
  EXPECT_EQ(report.status, Status::kTracked) << report.reason;
  EXPECT_LT(distance(report, target), 0.01);
  EXPECT_LT(distance(vision.targets()[1 - first].report, second_at(k - 1)), 0.01);
}

TEST(FoundAgain, WhatIsThereAfterAStallNeedNotBeTheTarget) {
  const StereoRig rig = level_rig();
  for (const int64_t stall : {2'000'000, 11'000'000}) {
    StereoVision vision({options_for(rig)});
    for (int k = 0; k < kConfirm; ++k) look(vision, rig, k * kFrame, {target_at(k)});
    ASSERT_TRUE(vision.targets().front().tracker.identity().confirmed());
    const int64_t after = kConfirm * kFrame + stall;
    const TargetReport& report = look(vision, rig, after, {{plate(0.03, 0.02, 0), {0.1, -0.05, 0.6}}});
    EXPECT_EQ(report.status, Status::kTracked);
    EXPECT_EQ(report.velocity.norm(), 0) << "a first match";
    const vision::TargetIdentity& identity = vision.targets().front().tracker.identity();
    EXPECT_FALSE(identity.confirmed());
    EXPECT_EQ(identity.known(), stall < 10'000'000);
    EXPECT_EQ(identity.found_again(), stall < 10'000'000);
  }
}

// The target is covered where it rests, while two things like it move elsewhere.
TEST(FoundAgain, NoneOfTwoEqualThingsElsewhereIsTheTargetThatHasJumped) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  for (int k = 0; k < kConfirm; ++k) look(vision, rig, k * kFrame, {target_at(k)});
  const TargetReport& report = vision.targets().front().report;
  ASSERT_TRUE(vision.targets().front().tracker.identity().confirmed());
  int coasting = 0;
  for (int k = kConfirm; k < kConfirm + 30; ++k) {
    const double x = -0.1 + 0.004 * (k - kConfirm);
    const Thing first{target_at(0).draw, {x, -0.1, 0.5}}, second{target_at(0).draw, {x + 0.12, -0.1, 0.5}};
    look(vision, rig, k * kFrame, {first, second});
    ASSERT_NE(report.status, Status::kTracked) << k << ' ' << report.estimate.position.transpose();
    if (report.status == Status::kCoasting) {
      ++coasting;
      ASSERT_STREQ(report.reason, "several things are seen, but none where the object can be by now") << k;
      ASSERT_GT(vision.targets().front().candidates.size(), 1U);
    }
  }
  EXPECT_GT(coasting, 5);
  EXPECT_TRUE(report.ambiguous);
}

// Two things that rest where the target may have been put down are not background for that.
TEST(FoundAgain, ThingsElsewhereAreNoBackgroundWhileOneMayBeTheTarget) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  for (int k = 0; k < kConfirm; ++k) look(vision, rig, k * kFrame, {target_at(k)});
  const StereoVision::Target& target = vision.targets().front();
  const Thing first{target_at(0).draw, {-0.1, -0.1, 0.5}}, second{target_at(0).draw, {0.1, -0.1, 0.5}};
  int k = kConfirm;
  for (; target.report.status != Status::kLost && k < kConfirm + 40; ++k) {
    look(vision, rig, k * kFrame, {first, second});
    if (target.report.status != Status::kCoasting) continue;
    for (const vision::Appearance& appearance : target.views[0].appearance) ASSERT_LT(appearance.background, 0.1) << k;
  }
  EXPECT_GT(k, kConfirm + 3);
}

// Where the time between the exposures makes a position uncertain, a thing behind the covered target is still no
// continuation of its track.
TEST(FoundAgain, AnUnknownMotionDoesNotMakeAnotherThingTheTarget) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  constexpr int64_t kLate = 5000;
  const auto show = [&](int64_t utime, const Thing& thing) {
    cv::Mat left = testing::wall(2), right = testing::wall(3);
    thing.draw(left, rig.left, thing.p_L);
    thing.draw(right, rig.right, rig.X_RL * thing.p_L);
    vision::DecodedImages images({utime, utime, utime + kLate}, left, right);
    EXPECT_EQ(vision.update(images), nullptr);
  };
  const StereoVision::Target& target = vision.targets().front();
  const testing::Draw ball = testing::disc(0.025);  // contours locate it precisely
  const Thing rests{ball, target_at(39).p_L};
  int k = 0;
  for (; k < 40; ++k) show(k * kFrame, {ball, target_at(k).p_L});
  for (; k < 60; ++k) show(k * kFrame, rests);
  ASSERT_TRUE(target.tracker.identity().confirmed());
  const Thing behind{testing::disc(0.028), 1.12 * rests.p_L};
  show(k * kFrame, behind);
  EXPECT_EQ(target.report.status, Status::kCoasting) << target.report.estimate.position.transpose();
}

// A target that moved at 2 m/s leaves the view, and another thing rests there; the right image is 5 ms late.
TEST(FoundAgain, TheMotionOfATargetDoesNotMoveAnotherThing) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  constexpr int64_t kLate = 5000;
  const Eigen::Vector3d velocity(2, 0, 0), rest(-0.1, -0.08, 0.5);
  const auto show = [&](int64_t utime, const Thing& in_left, const Thing& in_right) -> const TargetReport& {
    cv::Mat left = testing::wall(2), right = testing::wall(3);
    in_left.draw(left, rig.left, in_left.p_L);
    in_right.draw(right, rig.right, rig.X_RL * in_right.p_L);
    vision::DecodedImages images({utime, utime, utime + kLate}, left, right);
    EXPECT_EQ(vision.update(images), nullptr);
    return vision.targets().front().report;
  };
  const testing::Draw draw = target_at(0).draw;
  int64_t utime = 0;
  Eigen::Vector3d p(-0.25, 0.05, 0.5);
  for (int k = 0; k < 8; ++k, utime += kFrame, p += velocity * 1e-6 * kFrame) {
    const TargetReport& report = show(utime, {draw, p}, {draw, p + velocity * 1e-6 * kLate});
    if (k > 4) {
      ASSERT_LT((report.estimate.position - p).norm(), 0.01) << k;
    }
  }
  for (int k = 0; k < 3; ++k, utime += kFrame) show(utime, {draw, rest}, {draw, rest});
  const TargetReport& report = vision.targets().front().report;
  ASSERT_EQ(report.status, Status::kTracked);
  const Eigen::Vector3d error = report.estimate.position - rest;
  EXPECT_LT(std::sqrt(error.dot(report.estimate.covariance.ldlt().solve(error))), 4) << error.transpose();
}

/// A large disc that moves across, so that it is confirmed, comes near the right image's border, and goes away again.
Eigen::Vector3d near_and_away(int k) {
  if (k < 40) return {0.2 - 0.01 * k, 0, 0.8};
  if (k < 80) return {-0.2 + 0.001875 * (k - 40), 0, 0.8 - 0.0095 * (k - 40)};
  return {-0.125 - 0.0005 * (k - 80), 0, 0.42 + 0.003 * (k - 80)};
}

TEST(FoundAgain, BothWholeImagesAreSearchedInTheSamePair) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  constexpr int kEvery = 8;  // pairs
  int since = 0, one_whole = 0, neither = 0;
  for (int k = 0; k < 240; ++k) {
    look(vision, rig, k * kFrame, {{testing::disc(0.075), near_and_away(k)}});
    const StereoVision::Target& target = vision.targets().front();
    const bool left = target.views[0].window == target.tracker.search_area(Side::kLeft);
    const bool right = target.views[1].window == target.tracker.search_area(Side::kRight);
    since = left && right ? 0 : since + 1;
    one_whole += left != right ? 1 : 0;
    neither += !left && !right ? 1 : 0;
    ASSERT_LT(since, kEvery) << k;
  }
  EXPECT_GT(one_whole, 0) << "a window is more than half of one image, so that this image is searched more often";
  EXPECT_GT(neither, kEvery);
}

/// Follows a target that sways, while another thing moves to the left from a pair on.
void expect_followed(const testing::Draw& draw, const testing::Draw& other, int from, double speed) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)});
  for (int k = 0; k < 120; ++k) {
    const Thing target{draw, {0.15 * std::sin(0.05 * k), 0.05, 0.5}};
    std::vector<Thing> things{target};
    if (k >= from) things.push_back({other, {0.2 - speed * (k - from), -0.12, 0.5}});
    const TargetReport& report = look(vision, rig, k * kFrame, things);
    ASSERT_EQ(report.status, Status::kTracked) << k << ' ' << report.reason;
    EXPECT_LT(distance(report, target), 0.01) << k;
  }
}

TEST(FoundAgain, WhatIsFollowedUndisturbedIsNotDoubted) {
  expect_followed(target_at(0).draw, plate(0.06, 0.008, 0), 20, 0.003);
  // By itself, the larger one has more evidence: ln of the area.
  expect_followed(testing::disc(0.008), testing::disc(0.05), 40, 0.006);
}

TEST(FoundAgain, ARaggedThingIsNotTakenForTheTarget) {
  const StereoRig rig = level_rig();
  StereoVision vision({options_for(rig)}), fresh({options_for(rig)});
  int k = see_and_hide(vision, rig);
  // 60 x 6 pixels: not much smaller than the target of 50 x 50, but less compact.
  const auto stick_at = [](int at) { return Thing{plate(0.03, 0.003, 0), {0.15, -0.25 + 0.003 * at, 0.5}}; };
  ASSERT_EQ(look(fresh, rig, k * kFrame, {stick_at(k)}).status, Status::kTracked) << "alone, it may be the target";
  for (const int until = k + 40; k < until; ++k) {
    const TargetReport& report = look(vision, rig, k * kFrame, {stick_at(k)});
    ASSERT_EQ(report.status, Status::kLost) << k;
    ASSERT_STREQ(report.reason, "only things of another size, or much more ragged, than the target are seen");
  }
}

}  // namespace
}  // namespace multireach
