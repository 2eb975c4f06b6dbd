// Equal balls that are targets of their own: which is which.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "numeric/random.hpp"
#include "tests/tools/ball_images.hpp"
#include "vision/stereo_vision.hpp"

namespace multireach {
namespace {

using vision::StereoVision;
using Status = vision::TargetTrack::Status;

constexpr int64_t kFrame = 33333;
constexpr double kRadius = 0.033;

class EqualBalls : public ::testing::TestWithParam<double> {
 protected:
  EqualBalls()
      : left_(kScene, rig_.left, rig_.X_WL, rig_.X_WL), right_(kScene, rig_.right, rig_.X_RL.inverse(), rig_.X_WL) {}

  /// `pitch_px`: by how much the calibration has the right camera turned up wrongly.
  StereoVision vision_for(size_t targets, double pitch_px = 0) const {
    vision::TrackerOptions options;
    options.rig = rig_;
    options.rig.X_RL = Eigen::AngleAxisd(pitch_px / rig_.right.fy, Eigen::Vector3d::UnitX()) * rig_.X_RL;
    options.colour.fill(vision::model_of({.references = {{220, 40, 110}}, .tolerance = 0.55}));
    options.match.radius_m = GetParam();
    return StereoVision(std::vector<vision::TrackerOptions>(targets, options));
  }

  /// Shows a pair with these balls; a near one hides a far one.
  void look(int k, std::vector<Eigen::Vector3d> balls, StereoVision& vision) const {
    const auto stream = static_cast<uint64_t>(2 * k);
    std::ranges::sort(balls, std::greater<>(), [](const Eigen::Vector3d& ball) { return ball.z(); });
    cv::Mat left = left_.render(std::nullopt, stream), right = right_.render(std::nullopt, stream + 1);
    for (const Eigen::Vector3d& ball : balls) {
      testing::add_ball(left_, ball, stream, left);
      testing::add_ball(right_, ball, stream + 1, right);
    }
    const int64_t utime = k * kFrame;
    vision::DecodedImages images({utime, utime, utime}, left, right);
    ASSERT_EQ(vision.update(images), nullptr);
  }

  /// What became of the names of two balls: those of the pair `named`, until the last three pairs.
  struct Names {
    std::array<int, 2> name{-1, -1};
    bool kept = true;
    int wrong = 0;  // times that a name stood at the other ball
  };
  /// `balls`: both at a pair.
  Names follow(int pairs, int named, const std::function<std::vector<Eigen::Vector3d>(int)>& balls) const {
    StereoVision vision = vision_for(2);
    Names names;
    for (int k = 0; k < pairs; ++k) {
      const std::vector<Eigen::Vector3d> now = balls(k);
      look(k, now, vision);
      if (k == named) names.name = {target_at(vision, now[0]), target_at(vision, now[1])};
      for (size_t each = 0; k >= named && each < 2; ++each) {
        const int own = names.name[each], other = names.name[1 - each];
        names.wrong += other >= 0 && is_at(vision, static_cast<size_t>(other), now[each]);
        if (k >= pairs - 3) names.kept = names.kept && own >= 0 && is_at(vision, static_cast<size_t>(own), now[each]);
      }
    }
    return names;
  }

  static bool is_at(const StereoVision& vision, size_t target, const Eigen::Vector3d& ball) {
    const vision::TargetReport& report = vision.targets()[target].report;
    return report.status == Status::kTracked && (report.estimate.position - ball).norm() < 0.5 * kRadius;
  }
  /// The target that is said to be at a ball; -1: none, -2: several.
  static int target_at(const StereoVision& vision, const Eigen::Vector3d& ball) {
    int found = -1;
    for (size_t k = 0; k < vision.targets().size(); ++k) {
      if (is_at(vision, k, ball)) found = found == -1 ? static_cast<int>(k) : -2;
    }
    return found;
  }

 private:
  static constexpr SceneOptions kScene{.ball_radius_m = kRadius, .wall_distance_m = 3, .distractors = 0};
  StereoRig rig_ = parallel_rig(320, 240, 300, 0.12);
  BallRenderer left_, right_;
};

INSTANTIATE_TEST_SUITE_P(RadiusKnownOrNot, EqualBalls, ::testing::Values(kRadius, 0.0));

TEST_P(EqualBalls, OneBallIsOneTarget) {
  StereoVision vision = vision_for(2);
  int right = 0;
  for (int k = 0; k < 60; ++k) {
    const Eigen::Vector3d ball(-0.2 + 0.006 * k, 0.02, 1.2);
    look(k, {ball}, vision);
    right += is_at(vision, 0, ball);
    EXPECT_EQ(vision.targets()[1].report.status, Status::kLost) << k;
    EXPECT_STREQ(vision.targets()[1].report.reason, "only another target that looks the same is seen") << k;
  }
  EXPECT_EQ(right, 60);
}

TEST_P(EqualBalls, AsManyBallsAsTargetsAreAllFollowedAndOneMoreIsAmbiguous) {
  const std::vector<Eigen::Vector3d> balls{{-0.15, 0.03, 1.2}, {0.12, -0.05, 1.3}, {0.0, 0.1, 1.25}};
  StereoVision two = vision_for(2);
  for (int k = 0; k < 20; ++k) {
    look(k, {balls[0], balls[1]}, two);
    const int first = target_at(two, balls[0]), second = target_at(two, balls[1]);
    EXPECT_TRUE(first >= 0 && second >= 0 && first != second) << k << ": " << first << ", " << second;
  }
  StereoVision again = vision_for(2);
  for (int k = 0; k < 5; ++k) {
    look(k, balls, again);
    for (const StereoVision::Target& target : again.targets()) EXPECT_TRUE(target.report.ambiguous) << k;
  }
}

TEST_P(EqualBalls, SideBySideAtOneHeightAreBothFollowed) {
  StereoVision vision = vision_for(2);
  const Eigen::Vector3d left(-0.11, 0.02, 1.2), right(0.09, 0.02, 1.2);
  for (int k = 0; k < 20; ++k) {
    look(k, {left, right}, vision);
    const int first = target_at(vision, left), second = target_at(vision, right);
    EXPECT_TRUE(first >= 0 && second >= 0 && first != second) << k << ": " << first << ", " << second;
  }
}

TEST_P(EqualBalls, NewOnesThatCircleAreBothFollowedAtOnce) {
  // Between two pairs each moves by 6 cm; the other one's new place is 10 cm away. Which is which is not known, but
  // both are seen.
  StereoVision vision = vision_for(2);
  for (int k = 0; k < 6; ++k) {
    const double angle = k * std::numbers::pi / 3;
    const Eigen::Vector3d centre(0, 0, 1.2), away = 0.06 * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    look(k, {centre + away, centre - away}, vision);
    for (const double side : {-1.0, 1.0}) EXPECT_GE(target_at(vision, centre + side * away), 0) << k << ", " << side;
  }
}

TEST_P(EqualBalls, NewOnesThatComeTogetherAreNoBallBetweenThem) {
  for (const double apart : {1.6, 1.8, 2.0}) {  // radii; the second touches the first behind it
    StereoVision vision = vision_for(2);
    for (int k = 0; k < 5; ++k) {
      const double x = kRadius * (k == 0 ? 2 : 0.5 * apart);
      const double behind = k == 0 ? 0 : kRadius * std::sqrt(4 - apart * apart);
      const std::vector<Eigen::Vector3d> balls{{-x, 0, 1.2}, {x, 0.3 * x, 1.2 + behind}};
      look(k, balls, vision);
      if (k == 0) {
        EXPECT_TRUE(target_at(vision, balls[0]) >= 0 && target_at(vision, balls[1]) >= 0) << apart;
      }
      for (size_t target = 0; target < 2; ++target) {
        const vision::TargetReport& report = vision.targets()[target].report;
        EXPECT_TRUE(report.status != Status::kTracked || is_at(vision, target, balls[0]) ||
                    is_at(vision, target, balls[1]))
            << apart << " radii, pair " << k << ": " << report.estimate.position.transpose();
      }
    }
  }
}

TEST_P(EqualBalls, OneThatTurnsBackIsNotANewOne) {
  // The first ball turns back between two images, and so is outside of its prediction, but near a ball that is new.
  StereoVision vision = vision_for(2);
  constexpr int kTurns = 9;
  int found = 0, kept = 0;
  for (int k = 0; k < kTurns + 4; ++k) {
    const double away = 0.06 * std::abs(k - kTurns + 0.5);
    const Eigen::Vector3d first(0.05 - away, 0, 1.2), second(0.1, -0.15 + 0.04 * (k - kTurns), 1.2);
    std::vector<Eigen::Vector3d> balls{first};
    if (k >= kTurns - 1) balls.push_back(second);
    look(k, balls, vision);
    if (k < kTurns) continue;
    EXPECT_FALSE(is_at(vision, 0, second) || is_at(vision, 1, first)) << k;
    found += is_at(vision, 1, second);
    kept += is_at(vision, 0, first);
  }
  EXPECT_EQ(found, 4) << "pairs in which the new ball has its position";
  EXPECT_GE(kept, 3) << "pairs in which the first has its own: a jump takes two";
}

TEST_P(EqualBalls, OneIsNotTwoThatHaveJumpedThere) {
  StereoVision vision = vision_for(2);
  const Eigen::Vector3d there(0.02, 0.36, 1.2);  // too far away for a near jump of either
  int found = 0;
  for (int k = 0; k < 24; ++k) {
    const Eigen::Vector3d first(-0.25 + 0.01 * k, -0.1, 1.2), second(0.25 - 0.01 * k, -0.06, 1.25);
    look(k, k < 16 ? std::vector{first, second} : std::vector{there}, vision);
    if (k < 16) continue;
    EXPECT_NE(target_at(vision, there), -2) << k << ": two targets are at one ball";
    found += target_at(vision, there) >= 0;
  }
  EXPECT_GE(found, 4) << "pairs of 8";
}

TEST_P(EqualBalls, OneLeavesAndTheOtherEntersElsewhere) {
  StereoVision vision = vision_for(2);
  // The first leaves at the left border; while it coasts, the second, which was never seen, enters at the right one.
  int second_right = 0;
  for (int k = 0; k < 60; ++k) {
    const Eigen::Vector3d first(-0.4 - 0.01 * k, 0.1, 1.2), second(0.85 - 0.014 * k, -0.1, 1.2);
    look(k, {first, second}, vision);
    EXPECT_FALSE(is_at(vision, 0, second)) << k << ": the first name is at the second ball";
    if (k >= 50) second_right += is_at(vision, 1, second);
  }
  EXPECT_EQ(second_right, 10);
}

TEST_P(EqualBalls, OneLeavesAndTheOtherEntersThere) {
  StereoVision vision = vision_for(2);
  int first_right = 0, second_right = 0;
  for (int k = 0; k < 60; ++k) {
    const double time = k / 30.0;
    const Eigen::Vector3d first(0.2 - 0.8 * time, 0.06, 1.2), second(-1.078 + 0.55 * time, 0.015, 1.1);
    look(k, {first, second}, vision);
    if (k < 10) first_right += is_at(vision, 0, first);
    if (k >= 50) second_right += is_at(vision, 1, second);
  }
  EXPECT_EQ(first_right, 10);
  EXPECT_EQ(second_right, 10);
}

TEST_P(EqualBalls, WhatAppearsIsTheTargetThatIsNotSeenYet) {
  StereoVision vision = vision_for(2);
  const Eigen::Vector3d second(0.12, -0.05, 1.3);
  int right = 0;
  for (int k = 0; k < 60; ++k) {
    const Eigen::Vector3d first(-0.15, -0.1 + 0.003 * k, 1.2);
    std::vector<Eigen::Vector3d> balls{first};
    if (k >= 20) balls.push_back(second);
    look(k, balls, vision);
    right += is_at(vision, 0, first) && (k < 20 || is_at(vision, 1, second));
  }
  EXPECT_GE(right, 59) << "of 60";
  // The first one goes; the second keeps its name.
  for (int k = 60; k < 90; ++k) {
    look(k, {second}, vision);
    EXPECT_TRUE(is_at(vision, 1, second)) << k;
    EXPECT_NE(vision.targets()[0].report.status, Status::kTracked) << k;
  }
}

TEST_P(EqualBalls, ThatCrossKeepTheirNames) {
  // The near ball passes in front of the far one, which is hidden in between.
  int crossings = 0, kept = 0, wrong = 0;
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    const CounterRandom random(seed);
    uint64_t at = 0;
    const auto between = [&](double from, double to) { return random.uniform(at++, from, to); };
    const std::array x{between(-0.03, 0.03), between(-0.03, 0.03)};  // where they meet, by their direction
    const std::array depth{between(1.0, 1.15), between(1.25, 1.5)};
    std::array<Eigen::Vector3d, 2> velocity;
    for (Eigen::Vector3d& each : velocity) {
      for (double& coordinate : each) coordinate = between(-1, 1);
    }
    for (size_t k = 0; k < 2; ++k) velocity[k].x() = (k == 0 ? 1 : -1) * between(0.25, 0.8);
    for (size_t k = 0; k < 2; ++k)
      velocity[k].tail<2>() = velocity[k].tail<2>().cwiseProduct(Eigen::Vector2d(0.3, 0.1));
    constexpr int kPairs = 36, kMeet = 18;
    const Names names = follow(kPairs, 3, [&](int k) {
      std::vector<Eigen::Vector3d> balls;
      for (size_t each = 0; each < 2; ++each)
        balls.emplace_back(depth[each] * Eigen::Vector3d(x[0], x[1], 1) + velocity[each] * ((k - kMeet) / 30.0));
      return balls;
    });
    EXPECT_TRUE(names.name[0] >= 0 && names.name[1] >= 0 && names.name[0] != names.name[1]) << "seed " << seed;
    ++crossings;
    kept += names.kept;
    wrong += names.wrong;
    if (!names.kept) std::printf("seed %d: names are not kept\n", static_cast<int>(seed));
  }
  EXPECT_EQ(wrong, 0) << "images in which a name stood at the other ball";
  EXPECT_EQ(kept, crossings);
}

TEST_P(EqualBalls, ThatCollideKeepTheirNames) {
  // Balls of one mass collide elastically: along the line of their centres they exchange their velocities.
  int kept = 0, wrong = 0;
  constexpr int kCollisions = 12;
  for (uint64_t seed = 1; seed <= kCollisions; ++seed) {
    const CounterRandom random(100 + seed);
    uint64_t at = 0;
    const auto between = [&](double from, double to) { return random.uniform(at++, from, to); };
    const Eigen::Vector3d meet(between(-0.05, 0.05), between(-0.08, 0.08), between(1.0, 1.3));
    const Eigen::Vector3d line = Eigen::Vector3d(1, between(-0.4, 0.4), 0).normalized();
    const std::array<Eigen::Vector3d, 2> before{between(0.3, 1.0) * Eigen::Vector3d(1, between(-0.2, 0.2), 0),
                                                -between(0.3, 1.0) * Eigen::Vector3d(1, between(-0.2, 0.2), 0)};
    const double exchanged = line.dot(before[1] - before[0]);
    const std::array<Eigen::Vector3d, 2> after{before[0] + exchanged * line, before[1] - exchanged * line};
    constexpr int kPairs = 26, kMeet = 16;
    const double late = between(0, 1);  // the collision is between two images
    const Names names = follow(kPairs, 5, [&](int k) {
      const double time = (k - kMeet - late) / 30.0;
      std::vector<Eigen::Vector3d> balls;
      for (size_t each = 0; each < 2; ++each) {
        const double side = each == 0 ? -1 : 1;
        balls.emplace_back(meet + side * kRadius * line + (time < 0 ? before : after)[each] * time);
      }
      return balls;
    });
    kept += names.kept;
    wrong += names.wrong;
    if (!names.kept) std::printf("seed %d: names are not kept\n", static_cast<int>(seed));
  }
  EXPECT_EQ(wrong, 0) << "images in which a name stood at the other ball";
  EXPECT_EQ(kept, kCollisions);
}

TEST_P(EqualBalls, WithAWrongCalibrationImagesOfDifferentBallsAreNoPosition) {
  // By a right camera that is turned by 5 px, the left image of the first ball fits the right image of the second.
  constexpr double kPixels = 5, kOffset = kPixels * 1.2 / 300;  // m
  for (const double sign : {-1.0, 1.0}) {
    const std::vector<Eigen::Vector3d> balls{
        {0.12, 0, 1.2}, {0, sign * kOffset, 1.2}, {0.2, sign * 0.15, 1.2}, {-0.2, -sign * 0.15, 1.2}};
    StereoVision good = vision_for(4), wrong = vision_for(4, -sign * kPixels);
    look(0, balls, good);
    for (const StereoVision::Target& target : good.targets()) EXPECT_EQ(target.report.status, Status::kTracked);
    bool fits = false;
    for (int k = 0; k < 10; ++k) {
      look(k, balls, wrong);
      for (const StereoVision::Target& target : wrong.targets()) {
        EXPECT_EQ(target.report.status, Status::kLost) << k << " at " << target.report.estimate.position.transpose();
        fits = fits || !target.candidates.empty();
      }
    }
    EXPECT_EQ(fits, GetParam() == 0.0) << "a known radius tells it";
  }
}

}  // namespace
}  // namespace multireach
