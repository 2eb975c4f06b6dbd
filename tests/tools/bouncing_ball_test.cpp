// A ball that bounces: its motion changes between two pairs, and nothing else can be meant.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "numeric/random.hpp"
#include "tests/tools/ball_images.hpp"
#include "vision/stereo_vision.hpp"

namespace multireach {
namespace {

using vision::StereoVision;
using Status = vision::TargetTrack::Status;

constexpr int64_t kFrame = 33333;
constexpr double kRadius = 0.033;
const Eigen::Vector3d kPlace(0.1, 0.05, 1.2), kStep(0.08, 0, 0);
const Eigen::Vector3d kBack = kPlace - 0.9 * kStep;  // after a bounce

class BouncingBall : public ::testing::TestWithParam<double> {
 protected:
  using Balls = std::vector<Eigen::Vector3d>;

  BouncingBall() { start(1, 3); }

  void start(size_t targets, int confirmations) {
    vision::TrackerOptions options;
    options.track.confirmations = confirmations;
    options.rig = rig_;
    options.colour.fill(vision::model_of({.references = {{220, 40, 110}}, .tolerance = 0.55}));
    options.match.radius_m = GetParam();
    vision_ = std::make_unique<StereoVision>(std::vector(targets, options));
  }

  /// Shows the next pair, with balls of two sizes, bars that are not round, and balls that only the left camera sees;
  /// returns the first target's reason.
  std::string look(const Balls& balls, const Balls& smaller = {}, const std::vector<cv::Rect>& bars = {},
                   const Balls& left_only = {}) {
    const auto stream = static_cast<uint64_t>(2 * k_);
    cv::Mat left = left_.render(std::nullopt, stream), right = right_.render(std::nullopt, stream + 1);
    for (const Eigen::Vector3d& ball : balls) {
      testing::add_ball(left_, ball, stream, left);
      testing::add_ball(right_, ball, stream + 1, right);
    }
    for (const Eigen::Vector3d& ball : left_only) testing::add_ball(left_, ball, stream, left);
    for (const Eigen::Vector3d& ball : smaller) {
      testing::add_ball(small_left_, ball, stream, left);
      testing::add_ball(small_right_, ball, stream + 1, right);
    }
    for (const cv::Rect& bar : bars) {
      constexpr int kDisparity = 30;  // pixels: at 1.2 m
      cv::rectangle(left, bar, {110, 40, 220}, cv::FILLED);
      cv::rectangle(right, bar - cv::Point(kDisparity, 0), {110, 40, 220}, cv::FILLED);
    }
    const int64_t utime = ++k_ * kFrame;
    vision::DecodedImages images({utime, utime, utime}, left, right);
    EXPECT_EQ(vision_->update(images), nullptr);
    return report().reason;
  }
  /// Shows a ball that comes to kPlace at 2.4 m/s.
  void approach(const Balls& others = {}) {
    for (int k = -7; k <= 0; ++k) {
      Balls balls = others;
      balls.emplace_back(kPlace + k * kStep);
      look(balls);
    }
    ASSERT_TRUE(is_at(kPlace, name())) << report().reason;
  }
  /// The target that is at kPlace.
  size_t name() const { return vision_->targets().size() > 1 && is_at(kPlace, 1) ? 1 : 0; }

  /// The next pair is this many earlier.
  void go_back(int pairs) { k_ -= pairs; }
  std::vector<double> state() const { return vision_->serialize(0, k_ * kFrame); }
  const vision::TargetIdentity& identity() const { return vision_->targets()[0].tracker.identity(); }
  const vision::TargetReport& report(size_t target = 0) const { return vision_->targets()[target].report; }
  bool is_at(const Eigen::Vector3d& place, size_t target = 0) const {
    const vision::TargetReport& its = report(target);
    return its.status == Status::kTracked && (its.estimate.position - place).norm() < 0.5 * kRadius;
  }

 private:
  static SceneOptions scene(double radius_m) {
    return {.ball_radius_m = radius_m, .wall_distance_m = 3, .distractors = 0};
  }
  StereoRig rig_ = parallel_rig(320, 240, 300, 0.12);
  BallRenderer left_{scene(kRadius), rig_.left, rig_.X_WL, rig_.X_WL};
  BallRenderer right_{scene(kRadius), rig_.right, rig_.X_RL.inverse(), rig_.X_WL};
  BallRenderer small_left_{scene(0.45 * kRadius), rig_.left, rig_.X_WL, rig_.X_WL};
  BallRenderer small_right_{scene(0.45 * kRadius), rig_.right, rig_.X_RL.inverse(), rig_.X_WL};
  std::unique_ptr<StereoVision> vision_;
  int k_ = 0;
};

INSTANTIATE_TEST_SUITE_P(RadiusKnownOrNot, BouncingBall, ::testing::Values(kRadius, 0.0));

// Drops of a ball onto a table, from heights at which it arrives with 1.6 to 2.4 m/s, each at another time between two
// pairs, and at another place. A bounce turns its speed by 3 m/s or more: up to 10 cm from one pair to the next.
TEST_P(BouncingBall, IsTrackedInThePairAfterEachBounce) {
  constexpr double kTable = 0.3, kGravity = 9.81;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    const CounterRandom random(seed);
    const double height = random.uniform(0, 0.13, 0.3), restitution = random.uniform(1, 0.8, 0.95);
    const double late = random.uniform(2, 0, 1);
    const double fall_s = std::sqrt(2 * height / kGravity), rise_m_s = restitution * kGravity * fall_s;
    for (int k = 0; k < 14; ++k) {
      const double t = (k + late) / 30, after = t - fall_s;
      const double up = after < 0 ? height - 0.5 * kGravity * t * t : rise_m_s * after - 0.5 * kGravity * after * after;
      if (after > 2 * rise_m_s / kGravity) break;
      const Eigen::Vector3d ball(-0.4 + 0.09 * static_cast<double>(seed), kTable - kRadius - up, 1.2);
      const std::string reason = look({ball});
      EXPECT_TRUE(k < 3 || is_at(ball)) << "seed " << seed << ", " << k << ": " << reason;
    }
    for (int k = 0; k < 20; ++k) look({});
    ASSERT_EQ(report().status, Status::kLost);
  }
}

// To and fro between two walls for twelve seconds: a bounce is no reason to doubt that the ball is the target.
TEST_P(BouncingBall, StaysConfirmedHoweverOftenItBounces) {
  constexpr double kReach = 0.3;
  Eigen::Vector3d ball = kPlace, step = 0.9 * kStep;
  int missed = 0;
  for (int k = 0; k < 360; ++k) {
    if (std::abs(ball.x() + step.x()) > kReach) step = -step;
    ball += step;
    look({ball});
    missed += is_at(ball) ? 0 : 1;
  }
  EXPECT_LE(missed, 3) << "of 360 pairs; the first ones do not know its velocity";
  EXPECT_TRUE(identity().confirmed());
  EXPECT_FALSE(identity().doubtful(identity().last_utime()));
  if (GetParam() > 0) return;
  EXPECT_NEAR(identity().appearance(identity().last_utime()).radius_m, kRadius, 0.1 * kRadius);
}

TEST_P(BouncingBall, ALatePairChangesNothing) {
  approach();
  const std::vector<double> before = state();
  go_back(2);
  EXPECT_EQ(look({kBack}), "the pair is not newer than the last one");
  EXPECT_EQ(report().status, Status::kCoasting);
  go_back(-1);
  EXPECT_EQ(state(), before);
  look({kPlace + kStep});
  EXPECT_TRUE(is_at(kPlace + kStep)) << report().reason;
}

TEST_P(BouncingBall, AnotherThingInViewMustBeToldFromItFirst) {
  approach();
  const Eigen::Vector3d other(-0.35, -0.2, 1.2);
  look({kPlace + kStep, other});
  ASSERT_TRUE(is_at(kPlace + kStep)) << "it is expected there";
  look({kPlace, other});
  EXPECT_NE(report().status, Status::kTracked) << "either may be it";
}

// Its velocity is not known yet, so that it could be as far away as the other thing.
TEST_P(BouncingBall, AnotherThingIsNotTakenForItWhileOneCameraSeesIt) {
  const Eigen::Vector3d other = kPlace - Eigen::Vector3d(0.2, 0.1, 0);
  look({kPlace});
  ASSERT_TRUE(is_at(kPlace));
  look({other});
  ASSERT_TRUE(is_at(other)) << "without it the other thing may be it";
  start(1, 3);
  look({kPlace});
  ASSERT_TRUE(is_at(kPlace));
  EXPECT_EQ(look({other}, {}, {}, {kPlace}), "not seen in the right image");
  EXPECT_NE(report().status, Status::kTracked);
}

TEST_P(BouncingBall, AThingOfAnotherSizeOrShapeIsNotTakenForIt) {
  approach();
  look({}, {kBack});
  EXPECT_NE(report().status, Status::kTracked);
  start(1, 3);
  approach();
  look({}, {}, {{148, 130, 38, 5}});  // of nearly the ball's area
  EXPECT_NE(report().status, Status::kTracked);
}

TEST_P(BouncingBall, AThingThatRestsBesideItIsNotTakenForIt) {
  const Eigen::Vector3d other = kPlace + Eigen::Vector3d(0, 0.072, 0);
  Eigen::Vector3d ball = kPlace - 7 * kStep;
  for (int k = 0; k < 70; ++k) {
    ball.y() += k % 40 < 20 ? 0.01 : -0.01;
    look({ball, other});
  }
  approach({other});
  look({other});
  EXPECT_NE(report().status, Status::kTracked) << "the other one was there while the target was seen";
}

TEST_P(BouncingBall, WhatAppearsBesideAThingThatStandsStillMustBeSeenAgain) {
  if (GetParam() > 0) return;  // bars have no radius
  const cv::Rect first(150, 110, 22, 15), second(150, 80, 22, 15);
  for (int k = 0; k < 40; ++k) look({}, {}, {first});
  ASSERT_EQ(report().status, Status::kTracked);
  const Eigen::Vector3d place = report().estimate.position;
  look({}, {}, {first, second});
  EXPECT_TRUE(report().status != Status::kTracked || (report().estimate.position - place).norm() < kRadius);
}

TEST_P(BouncingBall, ABallAtRestDoesNotBounce) {
  for (int k = 0; k < 12; ++k) look({kPlace});
  ASSERT_TRUE(is_at(kPlace));
  look({kBack});
  EXPECT_NE(report().status, Status::kTracked) << "somebody may have covered it and shown another one";
}

TEST_P(BouncingBall, MayBeMissedOnceAfterTheBounce) {
  approach();
  look({kBack});
  ASSERT_TRUE(is_at(kBack)) << report().reason;
  look({});
  EXPECT_EQ(report().status, Status::kCoasting);
  look({kBack - 2 * kStep});
  EXPECT_TRUE(is_at(kBack - 2 * kStep)) << report().reason;
}

TEST_P(BouncingBall, WhatIsTooFarAwayOrComesTooLateMustBeSeenAgain) {
  approach();
  look({kPlace - 3 * kStep});
  EXPECT_NE(report().status, Status::kTracked) << "it would have to be at 7 m/s";
  start(1, 3);
  approach();
  look({});
  look({kBack});
  EXPECT_NE(report().status, Status::kTracked) << "nobody knows where it was in between";
}

TEST_P(BouncingBall, WithMoreConfirmationsABounceIsConfirmedToo) {
  start(1, 4);
  approach();
  look({kBack});
  EXPECT_NE(report().status, Status::kTracked);
}

TEST_P(BouncingBall, AnotherTargetInViewIsNoReasonToWait) {
  start(2, 3);
  const Eigen::Vector3d other(-0.3, -0.2, 1.2);
  approach({other});
  const size_t name = this->name();
  look({kBack, other});
  EXPECT_TRUE(is_at(kBack, name)) << report(name).reason;
  EXPECT_TRUE(is_at(other, 1 - name)) << report(1 - name).reason;
}

}  // namespace
}  // namespace multireach
