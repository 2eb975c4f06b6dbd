// Rendered pairs of a ball, or several, before folders of nearly its colour that stand still.
#pragma once

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "tests/tools/ball_images.hpp"
#include "vision/stereo_vision.hpp"

namespace multireach {

inline constexpr int64_t kFrame = 33333;
inline constexpr double kFocal = 300, kBaseline = 0.12;

inline StereoRig level_rig() {
  StereoRig rig;
  rig.left = {.width = 320, .height = 240, .fx = kFocal, .fy = kFocal, .cx = 160, .cy = 120, .distortion = {}};
  rig.right = rig.left;
  rig.X_RL = rig.X_WL = Eigen::Isometry3d::Identity();
  rig.X_RL.translation().x() = -kBaseline;
  return rig;
}

inline const std::vector<cv::Rect> kFolders{cv::Rect(60, 130, 26, 60), cv::Rect(92, 134, 22, 56)};

/// A room with folders on a shelf, larger than the ball and of nearly its colour.
class Room {
 public:
  explicit Room(const StereoRig& rig, const std::vector<cv::Rect>& folders = kFolders, double distance_m = 2.5)
      : folders_(folders),
        disparity_px_(cvRound(kFocal * kBaseline / distance_m)),
        left_(kScene, rig.left, rig.X_WL, rig.X_WL),
        right_(kScene, rig.right, rig.X_RL.inverse(), rig.X_WL) {}

  /// Shows a pair with one ball or several, which must not cover each other.
  void look(int k, const std::optional<Eigen::Vector3d>& ball, vision::StereoVision& vision,
            const std::vector<Eigen::Vector3d>& others = {}) const {
    look_twice(k, ball, ball, vision, others);
  }
  /// The same with cameras that are not synchronised: when the right one looks, the ball is elsewhere.
  void look_twice(int k, const std::optional<Eigen::Vector3d>& ball, const std::optional<Eigen::Vector3d>& later,
                  vision::StereoVision& vision, const std::vector<Eigen::Vector3d>& others = {}) const {
    const auto stream = static_cast<uint64_t>(2 * k);
    cv::Mat left = left_.render(ball, stream), right = right_.render(later, stream + 1);
    for (const Eigen::Vector3d& other : others) {
      testing::add_ball(left_, other, stream, left);
      testing::add_ball(right_, other, stream + 1, right);
    }
    for (const cv::Rect& folder : folders_) {
      cv::rectangle(left, folder, {88, 44, 208}, cv::FILLED);
      cv::rectangle(right, folder - cv::Point(disparity_px_, 0), {88, 44, 208}, cv::FILLED);
    }
    const int64_t utime = k * kFrame;
    vision::DecodedImages images({utime, utime, utime}, left, right);
    ASSERT_EQ(vision.update(images), nullptr);
  }

 private:
  static constexpr SceneOptions kScene{.ball_radius_m = 0.033, .wall_distance_m = 3, .distractors = 0};
  std::vector<cv::Rect> folders_;
  int disparity_px_;
  BallRenderer left_, right_;
};

inline vision::TrackerOptions options_for(const StereoRig& rig) {
  vision::TrackerOptions options;
  options.rig = rig;
  options.colour.fill(vision::model_of({.references = {{220, 40, 110}}, .tolerance = 0.55}));
  return options;
}

/// Gains of red and blue of both cameras, the last numbers of a tracker's own state.
inline std::vector<double> gains_of(const vision::StereoVision& vision, int64_t utime) {
  const std::vector<double> state = vision.targets().front().tracker.serialize(utime);
  return {state.end() - 4, state.end()};
}

inline vision::TrackerOptions options_with_radius(const StereoRig& rig) {
  vision::TrackerOptions options = options_for(rig);
  options.match.radius_m = 0.033;
  return options;
}

inline bool is_at(const vision::TargetReport& report, const Eigen::Vector3d& place) {
  return report.status == vision::TargetTrack::Status::kTracked && (report.estimate.position - place).norm() < 0.05;
}

}  // namespace multireach
