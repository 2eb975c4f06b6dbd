#include "vision/track/target_identity.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace multireach::vision {
namespace {

constexpr int64_t kFrame = 33333;

TargetIdentity::Observation at(double x, double background, bool by_contour = false) {
  return {.by_contour = by_contour,
          .px = {Eigen::Vector2d(x, 100), Eigen::Vector2d(x - 20, 100)},
          .radius_px = 10,
          .background = {background, background}};
}

TargetTrack::Start starts(bool elsewhere) {
  return elsewhere ? TargetTrack::Start::kFirst : TargetTrack::Start::kNone;
}

TEST(TargetIdentity, WhatStandsStillIsConfirmedByItsContourOnlyUnlessTheColourWasThereBefore) {
  TargetIdentity still, sphere, scene, known_ball;
  for (int k = 0; k < 100; ++k) {
    still.update(k * kFrame, at(100 + k % 3, 0.9), starts(k == 0));
    sphere.update(k * kFrame, at(100, 0.4, true), starts(k == 0));
    scene.update(k * kFrame, at(100, 0.6, true), starts(k == 0));
    TargetIdentity::Observation of_its_size = at(100, 0.6, true);
    of_its_size.of_known_size = true;
    known_ball.update(k * kFrame, of_its_size, starts(k == 0));
    EXPECT_EQ(known_ball.confirmed(), k >= 2);
    EXPECT_FALSE(still.confirmed());
    EXPECT_EQ(sphere.confirmed(), k >= 2);
    EXPECT_FALSE(scene.confirmed());
  }
}

TEST(TargetIdentity, WhatMovedAwayFromItsPlaceIsConfirmedUnlessTheColourWasThereBefore) {
  TargetIdentity moving, along_a_shelf;
  for (int k = 0; k < 20; ++k) {
    moving.update(k * kFrame, at(100 + 4 * k, 0.1), starts(k == 0));
    along_a_shelf.update(k * kFrame, at(100 + 4 * k, 0.8), starts(k == 0));
    EXPECT_EQ(moving.confirmed(), k >= 8) << k << ": three matches beyond its diameter";
    EXPECT_FALSE(along_a_shelf.confirmed());
  }
  moving.update(20 * kFrame, at(300, 0), TargetTrack::Start::kJump);
  EXPECT_FALSE(moving.confirmed()) << "after a jump it may be something else";
  EXPECT_TRUE(moving.known());
}

TEST(TargetIdentity, IsKnownForSomeTimeAfterItWasLost) {
  TargetIdentity identity;
  for (int k = 0; k < 3; ++k) identity.update(k * kFrame, at(100, 0, true), starts(k == 0));
  identity.update_unseen(3 * kFrame, false);
  EXPECT_TRUE(identity.confirmed()) << "coasting";
  identity.update_unseen(9000000, true);
  EXPECT_FALSE(identity.confirmed());
  EXPECT_TRUE(identity.known());
  identity.update_unseen(2 * kFrame + 10000001, true);
  EXPECT_FALSE(identity.known());
}

TEST(TargetIdentity, IsEstablishedUntilItIsLost) {
  TargetIdentity identity;
  const auto confirm = [&](int64_t from) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_FALSE(identity.established()) << k;
      identity.update(from + k * kFrame, at(100, 0, true), starts(k == 0));
    }
    EXPECT_TRUE(identity.established());
  };
  const auto saved = [&](int64_t utime) {
    TargetIdentity other;
    EXPECT_TRUE(other.deserialize(utime, identity.serialize(utime)));
    EXPECT_EQ(other.established(), identity.established());
    EXPECT_EQ(other.known(), identity.known());
    return other;
  };
  confirm(0);
  identity.update(3 * kFrame, at(300, 0), TargetTrack::Start::kJump);
  EXPECT_FALSE(identity.confirmed());
  EXPECT_TRUE(identity.established()) << "it has jumped";
  identity.update_unseen(4 * kFrame, true);
  EXPECT_TRUE(identity.known());
  EXPECT_FALSE(identity.established());
  identity = saved(4 * kFrame);
  confirm(5 * kFrame);
  identity = saved(7 * kFrame);
  EXPECT_TRUE(identity.established());
  identity.update_unseen(20000000, true);
  EXPECT_FALSE(identity.known() || identity.established());
  std::vector<double> impossible = identity.serialize(20000000);
  impossible[1] = 1;  // confirmed
  impossible[2] = 2;  // but lost since
  EXPECT_FALSE(identity.deserialize(20000000, impossible));
}

TEST(TargetIdentity, GoesOnFromItsState) {
  TargetIdentity identity;
  for (int k = 0; k < 8; ++k) identity.update(k * kFrame, at(100 + 4 * k, 0.1), starts(k == 0));
  const int64_t now = 9 * kFrame;
  const std::vector<double> state = identity.serialize(now);
  ASSERT_EQ(state.size(), TargetIdentity::kSerializedSize);
  TargetIdentity other;
  ASSERT_TRUE(other.deserialize(now, state));
  for (int k = 9; k < 12; ++k) {
    for (TargetIdentity* each : {&identity, &other})
      each->update(k * kFrame, at(100 + 4 * k, 0.1), TargetTrack::Start::kNone);
    EXPECT_EQ(identity.serialize(k * kFrame), other.serialize(k * kFrame));
  }
  std::vector<double> damaged = state;
  damaged[1] = 0.5;
  EXPECT_FALSE(other.deserialize(now, damaged));
  damaged = state;
  damaged[12] = 1e300;
  EXPECT_FALSE(other.deserialize(now, damaged)) << "no pixel is there";
  EXPECT_FALSE(other.deserialize(now, std::span(state).first(5)));
}

TargetIdentity::Observation looks(double radius_m, double compactness) {
  TargetIdentity::Observation observation = at(100, 0, true);
  observation.appearance = {radius_m, compactness};
  return observation;
}

TEST(TargetIdentity, RemembersTheLookOfTheConfirmedTarget) {
  TargetIdentity identity;
  int64_t utime = 0;
  const auto see = [&](int pairs, double radius_m, double compactness, bool elsewhere) {
    for (int k = 0; k < pairs; ++k, utime += kFrame)
      identity.update(utime, looks(radius_m, compactness), starts(elsewhere && k == 0));
  };
  see(2, 0.04, 0.8, true);
  EXPECT_EQ(identity.appearance(utime).radius_m, 0) << "not confirmed";
  see(1, 0.04, 0.8, false);
  EXPECT_EQ(identity.appearance(utime).radius_m, 0.04);
  EXPECT_EQ(identity.appearance(utime).compactness, 0.8);
  see(15, 0.08, 0.4, false);
  EXPECT_NEAR(identity.appearance(utime).radius_m, 0.08 - 0.04 * std::exp(-1), 1e-3)
      << "half a second is its time constant";
  EXPECT_NEAR(identity.appearance(utime).compactness, 0.4 + 0.4 * std::exp(-1), 1e-2);

  const double radius_m = identity.appearance(utime).radius_m;
  identity.update_unseen(utime, true);
  see(290, 0.01, 0.1, true);
  EXPECT_TRUE(identity.confirmed());
  EXPECT_TRUE(identity.doubtful(utime));
  EXPECT_EQ(identity.appearance(utime).radius_m, radius_m) << "what was found again may be another thing";
  see(100, 0.01, 0.1, false);
  EXPECT_FALSE(identity.doubtful(utime));
  EXPECT_NEAR(identity.appearance(utime).radius_m, 0.01, 1e-3) << "after ten seconds, it is the target";

  TargetIdentity restored;
  ASSERT_TRUE(restored.deserialize(utime, identity.serialize(utime)));
  EXPECT_EQ(restored.appearance(utime).radius_m, identity.appearance(utime).radius_m);
  EXPECT_EQ(restored.appearance(utime).compactness, identity.appearance(utime).compactness);
  identity.update_unseen(utime + 11'000'000, true);
  EXPECT_EQ(identity.appearance(utime).radius_m, 0) << "forgotten";
}

// As of a ball that the border cuts off: its blob does not tell its size, its contour shows that it is the same.
TEST(TargetIdentity, RemembersWhatItLooksLikeWhileASpheresContourIsSeen) {
  TargetIdentity ball, blob;
  for (TargetIdentity* identity : {&ball, &blob}) {
    TargetIdentity::Observation whole = at(100, 0, true);
    whole.appearance = {.radius_m = 0.03, .compactness = 0.9};
    for (int k = 0; k < 5; ++k) identity->update(k * kFrame, whole, starts(k == 0));
    for (int k = 5; k < 450; ++k) identity->update(k * kFrame, at(100, 0, identity == &ball), starts(false));
  }
  EXPECT_EQ(ball.appearance(449 * kFrame).radius_m, 0.03) << "after fifteen seconds";
  EXPECT_EQ(blob.appearance(449 * kFrame).radius_m, 0);
  EXPECT_EQ(ball.appearance(449 * kFrame + 10000001).radius_m, 0) << "ten seconds after it was seen";
}

// A bounce is the target's own motion: it stays confirmed and without doubt, and its appearance is learned.
TEST(TargetIdentity, ABounceLeavesNoDoubt) {
  TargetIdentity identity;
  TargetIdentity::Observation observation = at(100, 0, true);
  observation.convincing = true;
  observation.appearance = {.radius_m = 0.03, .compactness = 0.9};
  for (int k = 0; k < 450; ++k) {
    const bool bounces = k % 15 == 14;
    if (bounces) observation.px = {Eigen::Vector2d(100 + k, 100), Eigen::Vector2d(80 + k, 100)};
    identity.update(k * kFrame, observation, bounces ? TargetTrack::Start::kJumpAtOnce : starts(k == 0));
    EXPECT_EQ(identity.confirmed(), k >= 2) << k;
    EXPECT_FALSE(identity.doubtful(k * kFrame)) << k;
  }
  EXPECT_NEAR(identity.appearance(449 * kFrame).radius_m, 0.03, 1e-9) << "after fifteen seconds";
}

TEST(TargetIdentity, IsInDoubtForTenSecondsAfterItWasFoundAgainOrUntilItConvinces) {
  const auto seen_at = [](int64_t utime, bool convincing, bool elsewhere, TargetIdentity& identity) {
    TargetIdentity::Observation observation = at(100, 0, true);
    observation.convincing = convincing;
    identity.update(utime, observation, starts(elsewhere));
  };
  TargetIdentity identity;
  seen_at(0, false, true, identity);
  EXPECT_TRUE(identity.doubtful(kFrame)) << "a speck";
  seen_at(kFrame, true, false, identity);
  seen_at(2 * kFrame, false, false, identity);
  EXPECT_FALSE(identity.doubtful(3 * kFrame)) << "it was more than a speck";
  ASSERT_TRUE(identity.known());
  identity.update_unseen(3 * kFrame, true);
  seen_at(4 * kFrame, true, true, identity);
  for (const int64_t later : {kFrame, int64_t{9'900'000}}) {
    const int64_t now = 4 * kFrame + later;
    EXPECT_TRUE(identity.doubtful(now)) << "found again, it may be another thing";
    TargetIdentity restored;
    ASSERT_TRUE(restored.deserialize(now, identity.serialize(now)));
    EXPECT_TRUE(restored.doubtful(now));
    EXPECT_EQ(restored.serialize(now - 50'000), identity.serialize(now - 50'000)) << "also of a late pair";
  }
  EXPECT_FALSE(identity.doubtful(4 * kFrame + 10'000'000));
}

}  // namespace
}  // namespace multireach::vision
