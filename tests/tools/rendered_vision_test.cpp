// The tracker against rendered truth: exact images of a sphere through real lens models.
#include <gtest/gtest.h>

#include <cmath>

#include "camera/rendering/ball_renderer.hpp"
#include "numeric/random.hpp"
#include "vision/node/vision_node.hpp"
#include "vision/stereo_tracker.hpp"

namespace multireach {
namespace {

VisionConfig hoap2_vision() {
  return VisionConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml");
}

struct Stage {
  explicit Stage(const VisionConfig& vision, const SceneOptions& scene = {})
      : rig(vision.rig),
        left(scene, rig.left, rig.X_WL, rig.X_WL),
        right(scene, rig.right, rig.X_WL * rig.X_RL.inverse(), rig.X_WL) {}
  StereoRig rig;
  BallRenderer left, right;
};

TEST(RenderedVision, FindsTheCentreOfASphere) {
  const VisionConfig config = hoap2_vision();
  const Stage stage(config, {.distractors = 0, .noise_grey_levels = 1});
  vision::StereoTracker tracker(config.targets.front().options);
  const CounterRandom random(11);
  double sum2 = 0;
  constexpr uint64_t kBalls = 30;
  for (uint64_t k = 0; k < kBalls; ++k) {
    const Eigen::Vector3d p_WB(random.uniform(3 * k, 0.03, 0.14), random.uniform(3 * k + 1, -0.2, -0.03),
                               random.uniform(3 * k + 2, 0, 0.15));
    const vision::StereoMatch match =
        tracker.find(stage.left.render(p_WB, 2 * k), stage.right.render(p_WB, 2 * k + 1)).match;
    ASSERT_EQ(match.status, vision::StereoMatch::Status::kSeen) << description(match.status);
    sum2 += (match.point.p_W - p_WB).squaredNorm();
    EXPECT_LT(match.point.epipolar_error_px, 1);
  }
  EXPECT_LT(std::sqrt(sum2 / kBalls), 1.0e-3) << "RMS, m";
}

TEST(RenderedVision, ALargeBallIsWhereItsCentreIs) {
  // The middle of its contour is that of a place r^2 / Z nearer: 6 mm. With its radius known or not.
  VisionConfig config = hoap2_vision();
  const SceneOptions scene{.ball_radius_m = 0.05, .distractors = 0, .noise_grey_levels = 0};
  const Stage stage(config, scene);
  const Eigen::Vector3d p_WB(0.1, -0.1, 0.08);
  const cv::Mat left = stage.left.render(p_WB, 0), right = stage.right.render(p_WB, 1);
  const double truth = (stage.rig.X_WL.inverse() * p_WB).z();
  for (const double radius : {0.05, 0.0}) {
    config.targets.front().options.match.radius_m = radius;
    const double depth =
        vision::StereoTracker(config.targets.front().options).find(left, right).match.point.depth_left_m;
    EXPECT_NEAR(depth, truth, 1e-3) << radius;
  }
}

TEST(RenderedVision, SaysWhyItSeesNothing) {
  using Status = vision::StereoMatch::Status;
  const VisionConfig config = hoap2_vision();
  const Stage stage(config);
  vision::StereoTracker tracker(config.targets.front().options);
  const Eigen::Vector3d ball(0.1, -0.1, 0.08), other(0.1, -0.1, 0.12);
  const Eigen::Vector3d elsewhere(0.02, -0.1, 0.0);
  const auto status = [&](const std::optional<Eigen::Vector3d>& left, const std::optional<Eigen::Vector3d>& right) {
    return tracker.find(stage.left.render(left, 0), stage.right.render(right, 1)).match.status;
  };
  EXPECT_EQ(status(ball, ball), Status::kSeen);
  EXPECT_EQ(status(std::nullopt, ball), Status::kNotInLeft);
  EXPECT_EQ(status(ball, std::nullopt), Status::kNotInRight);
  EXPECT_EQ(status(ball, elsewhere), Status::kEpipolarMismatch);
  const cv::Mat small(100, 100, CV_8UC3, cv::Scalar(0, 0, 0));
  EXPECT_EQ(tracker.find(small, small).match.status, Status::kWrongImageSize);
  const cv::Mat pink(240, 320, CV_8UC3, cv::Scalar(110, 40, 220));
  EXPECT_EQ(tracker.find(pink, pink).match.status, Status::kColourEverywhere);
}

TEST(RenderedVision, RefusesSwappedCamerasAndOtherNonsense) {
  vision::TrackerOptions options = hoap2_vision().targets.front().options;
  EXPECT_NO_THROW(vision::StereoTracker{options});
  auto swapped = options;
  swapped.rig.X_RL = options.rig.X_RL.inverse();
  EXPECT_THROW(vision::StereoTracker{swapped}, std::invalid_argument);
  auto no_colour = options;
  no_colour.colour[0].object.clear();
  EXPECT_THROW(vision::StereoTracker{no_colour}, std::invalid_argument);
  auto one_place = options;
  one_place.rig.X_RL.setIdentity();
  EXPECT_THROW(vision::StereoTracker{one_place}, std::invalid_argument);
}

TEST(Rendering, TheSameSeedGivesTheSamePixels) {
  const VisionConfig config = hoap2_vision();
  const Stage first(config), second(config), other(config, {.seed = 2});
  const Eigen::Vector3d ball(0.1, -0.1, 0.08);
  EXPECT_EQ(cv::norm(first.left.render(ball, 5), second.left.render(ball, 5)), 0);
  EXPECT_GT(cv::norm(first.left.render(ball, 5), first.left.render(ball, 6)), 0) << "the noise of another frame";
  EXPECT_GT(cv::norm(first.left.render(ball, 5), other.left.render(ball, 5)), 0);
}

}  // namespace
}  // namespace multireach
