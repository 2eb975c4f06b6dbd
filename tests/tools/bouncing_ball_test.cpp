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
const Eigen::Vector3d kPlace(0.1, 0.05, 1.2);

class BouncingBall : public ::testing::TestWithParam<double> {
 protected:
  using Balls = std::vector<Eigen::Vector3d>;

  BouncingBall() {
    vision::TrackerOptions options;
    options.rig = rig_;
    options.colour.fill(vision::model_of({.references = {{220, 40, 110}}, .tolerance = 0.55}));
    options.match.radius_m = GetParam();
    vision_ = std::make_unique<StereoVision>(std::vector{options});
  }

  /// Shows the next pair, with balls of two sizes; returns the reason.
  std::string look(const Balls& balls, const Balls& smaller = {}) {
    const auto stream = static_cast<uint64_t>(2 * k_);
    cv::Mat left = left_.render(std::nullopt, stream), right = right_.render(std::nullopt, stream + 1);
    for (const Eigen::Vector3d& ball : balls) {
      testing::add_ball(left_, ball, stream, left);
      testing::add_ball(right_, ball, stream + 1, right);
    }
    for (const Eigen::Vector3d& ball : smaller) {
      testing::add_ball(small_left_, ball, stream, left);
      testing::add_ball(small_right_, ball, stream + 1, right);
    }
    const int64_t utime = ++k_ * kFrame;
    vision::DecodedImages images({utime, utime, utime}, left, right);
    EXPECT_EQ(vision_->update(images), nullptr);
    return report().reason;
  }
  /// Shows a ball at rest until it is tracked and the images' background is known.
  void rest(int pairs = 12) {
    for (int k = 0; k < pairs; ++k) look({kPlace});
    ASSERT_TRUE(is_at(kPlace)) << report().reason;
  }

  const vision::TargetReport& report() const { return vision_->targets().front().report; }
  bool is_at(const Eigen::Vector3d& place) const {
    return report().status == Status::kTracked && (report().estimate.position - place).norm() < 0.5 * kRadius;
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
// pairs. A bounce turns its speed by 3 m/s or more: up to 10 cm from one pair to the next.
TEST_P(BouncingBall, IsTrackedInThePairAfterEachBounce) {
  constexpr double kTable = 0.3, kGravity = 9.81;
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    const CounterRandom random(seed);
    const double height = random.uniform(0, 0.13, 0.3), restitution = random.uniform(1, 0.8, 0.95);
    const double late = random.uniform(2, 0, 1);
    const double fall_s = std::sqrt(2 * height / kGravity), rise_m_s = restitution * kGravity * fall_s;
    rest(1);
    for (int k = 0; k < 14; ++k) {
      const double t = (k + late) / 30, after = t - fall_s;
      const double up = after < 0 ? height - 0.5 * kGravity * t * t : rise_m_s * after - 0.5 * kGravity * after * after;
      if (after > 2 * rise_m_s / kGravity) break;
      const Eigen::Vector3d ball(0.1, kTable - kRadius - up, 1.2);
      const std::string reason = look({ball});
      EXPECT_TRUE(k < 3 || is_at(ball)) << "seed " << seed << ", " << k << ": " << reason;
    }
    for (int k = 0; k < 20; ++k) look({});
    ASSERT_EQ(report().status, Status::kLost);
  }
}

TEST_P(BouncingBall, AnotherThingInViewMustBeToldFromItFirst) {
  rest();
  const Eigen::Vector3d there = kPlace + Eigen::Vector3d(0, -0.09, 0), other(-0.25, -0.1, 1.2);
  look({kPlace, other});
  ASSERT_TRUE(is_at(kPlace)) << "it is expected there";
  look({there, other});
  EXPECT_NE(report().status, Status::kTracked) << "either may be it";
}

TEST_P(BouncingBall, AThingOfAnotherSizeIsNotTakenForIt) {
  rest();
  const Eigen::Vector3d there = kPlace + Eigen::Vector3d(0, -0.09, 0);
  look({}, {there});
  EXPECT_NE(report().status, Status::kTracked);
}

TEST_P(BouncingBall, WhatIsTooFarAwayOrComesTooLateMustBeSeenAgain) {
  rest();
  look({kPlace + Eigen::Vector3d(-0.3, -0.1, 0)});
  EXPECT_NE(report().status, Status::kTracked) << "it would have to be at 9 m/s";
  for (int k = 0; k < 3; ++k) look({kPlace});
  ASSERT_TRUE(is_at(kPlace));
  for (int k = 0; k < 4; ++k) look({});
  look({kPlace + Eigen::Vector3d(0, -0.3, 0)});
  EXPECT_NE(report().status, Status::kTracked) << "nobody knows where it was in between";
}

}  // namespace
}  // namespace multireach
