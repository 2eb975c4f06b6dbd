// What vision's NODE_STATUS says of cameras that have moved, and of a calibration that does not fit.
#include <gtest/gtest.h>

#include <multireach/images_t.hpp>
#include <optional>

#include "runtime/channels.hpp"
#include "tests/tools/ball_images.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach {
namespace {

const Eigen::Vector3d kBall(0.09, -0.1, 0.08);
constexpr double kRadius = 0.02;

class VisionRemarks : public ::testing::Test {
 protected:
  VisionRemarks()
      : config_(VisionConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml")), X_WL_(config_.rig.X_WL) {}

  /// The true rig differs from the configured one, by rotations about the cameras' own axes, rad.
  void turn(const Eigen::Vector3d& left, const Eigen::Vector3d& right) {
    left_turn_ = turn_of(left);
    right_turn_ = turn_of(right);
  }

  std::string state_after(VisionNode& node, int pairs, double radius_m = kRadius) {
    const SceneOptions scene{.ball_radius_m = radius_m, .distractors = 8};
    const StereoRig& rig = config_.rig;
    const BallRenderer left(scene, rig.left, X_WL_ * left_turn_, X_WL_);
    const BallRenderer right(scene, rig.right, X_WL_ * rig.X_RL.inverse() * right_turn_, X_WL_);
    for (int end = shown_ + pairs; shown_ < end; ++shown_) {
      images_t pair{};
      pair.utime = 1'000'000 + shown_ * 33'333;
      pair.n_images = 2;
      pair.image_types = {images_t::LEFT, images_t::RIGHT};
      for (const BallRenderer* camera : {&left, &right}) {
        const int stream = 2 * stream_.value_or(shown_) + (camera == &right ? 1 : 0);
        const cv::Mat bgr = camera->render(kBall, static_cast<uint64_t>(stream));
        pair.images.push_back(testing::image_message(bgr, pair.utime));
      }
      Outbox out;
      node.receive(channel::kStereoImages, *encode(pair), out);
    }
    return node.state();
  }

  static Eigen::Isometry3d turn_of(const Eigen::Vector3d& w) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    if (!w.isZero()) X.linear() = Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
    return X;
  }

  VisionConfig config_;
  Eigen::Isometry3d X_WL_, left_turn_ = Eigen::Isometry3d::Identity(), right_turn_ = left_turn_;
  int shown_ = 0;
  std::optional<int> stream_;  // of random numbers for the noise of all pairs; none: each pair has its own
};

TEST_F(VisionRemarks, NothingWhereAllIsWell) {
  VisionNode node(config_);
  EXPECT_EQ(state_after(node, 150), config_.targets.front().name + " tracked");
}

TEST_F(VisionRemarks, BothCamerasRepeatTheirImages) {
  VisionNode node(config_);
  stream_ = 7;
  EXPECT_EQ(state_after(node, 5), config_.targets.front().name + " tracked") << "too few pairs to say it";
  EXPECT_EQ(state_after(node, 1), config_.targets.front().name +
                                      " tracked; both cameras repeat the same images: a still picture, or both are "
                                      "frozen");
  stream_.reset();
  EXPECT_EQ(state_after(node, 1), config_.targets.front().name + " tracked");
}

TEST_F(VisionRemarks, ThePitchOfOneCameraIsOff) {
  // A turn about x moves the image by f w rows.
  const double rows = 1.2;
  turn({0, 0, 0}, {rows / config_.rig.right.fy, 0, 0});
  VisionNode node(config_);
  EXPECT_EQ(state_after(node, 90), config_.targets.front().name + " tracked") << "too few pairs to say it";
  const std::string state = state_after(node, 60);
  EXPECT_NE(state.find("differ by 1.2 px between the images: calibrate again"), std::string::npos) << state;
}

TEST_F(VisionRemarks, TheBallIsLargerThanItsRadius) {
  VisionNode node(config_);
  const std::string state = state_after(node, 150, 1.03 * kRadius);
  EXPECT_NE(state.find("looks 3 % larger than its ball_radius_m"), std::string::npos) << state;
}

TEST_F(VisionRemarks, ACameraMovesAndHasMoved) {
  VisionNode node(config_);
  state_after(node, 60);
  const double px = 8;
  turn({0, px / config_.rig.left.fx, 0}, {0, px / config_.rig.right.fx, 0});  // both: the stand was pushed
  std::string state = state_after(node, 20);
  EXPECT_NE(state.find("the left camera moves; the right camera moves"), std::string::npos) << state;
  state = state_after(node, 80);
  for (const char* side : {"left", "right"}) {
    const size_t at = state.find(std::string("the ") + side + " camera has moved by about ");
    ASSERT_NE(at, std::string::npos) << state;
    EXPECT_NEAR(std::atof(state.c_str() + state.find("about ", at) + 6), px, 0.5 * px) << state;
  }
}

}  // namespace
}  // namespace multireach
