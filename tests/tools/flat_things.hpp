#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <opencv2/imgproc.hpp>

#include "vision/colour/learn_colour.hpp"
#include "vision/stereo_vision.hpp"

/// Red things before a grey wall, drawn flat.
namespace multireach::testing {

inline constexpr int kWidth = 640, kHeight = 480;
inline constexpr double kFocal = 500;
inline constexpr int64_t kFrame = 33333;
inline constexpr int kBits = 4;  // OpenCV draws in 16ths of a pixel

inline StereoRig level_rig() {
  StereoRig rig = parallel_rig(kWidth, kHeight, kFocal, 0.06);
  rig.left.cx = rig.right.cx = kWidth / 2;
  return rig;
}

inline int sixteenths(double pixels) {
  return cvRound(pixels * (1 << kBits));
}

/// Draws something at a position in a camera's frame.
using Draw = std::function<void(cv::Mat& image, const CameraModel& camera, const Eigen::Vector3d& p_C)>;

inline const cv::Scalar kRed(40, 40, 200);

/// A plate that faces the cameras: half its sides, m, and how it is turned, degrees.
inline Draw plate(double half_length, double half_width, double angle) {
  return [=](cv::Mat& image, const CameraModel& camera, const Eigen::Vector3d& p_C) {
    const Eigen::Vector2d centre = camera.project(p_C);
    const double scale = 2 * camera.fx / p_C.z();
    const cv::RotatedRect box(
        cv::Point2f(static_cast<float>(centre.x()), static_cast<float>(centre.y())),
        cv::Size2f(static_cast<float>(scale * half_length), static_cast<float>(scale * half_width)),
        static_cast<float>(angle));
    std::array<cv::Point2f, 4> corners;
    box.points(corners.data());
    std::vector<cv::Point> polygon;
    for (const cv::Point2f& corner : corners) polygon.emplace_back(sixteenths(corner.x), sixteenths(corner.y));
    cv::fillConvexPoly(image, polygon, kRed, cv::LINE_AA, kBits);
  };
}

inline Draw disc(double radius) {
  return [=](cv::Mat& image, const CameraModel& camera, const Eigen::Vector3d& p_C) {
    const Eigen::Vector2d centre = camera.project(p_C);
    cv::circle(image, {sixteenths(centre.x()), sixteenths(centre.y())}, sixteenths(camera.fx * radius / p_C.z()), kRed,
               cv::FILLED, cv::LINE_AA, kBits);
  };
}

inline cv::Mat wall(uint64_t seed) {
  cv::Mat image(kHeight, kWidth, CV_8UC3);
  cv::RNG(seed).fill(image, cv::RNG::NORMAL, cv::Scalar(110, 110, 110), cv::Scalar(3, 3, 3));
  return image;
}

inline vision::TrackerOptions options_for(const StereoRig& rig) {
  cv::Mat image = wall(1);
  plate(0.05, 0.05, 0)(image, rig.left, {0, 0, 0.5});
  const vision::LearnedColour learned = vision::learn_colour(image, cv::Rect(272, 192, 96, 96));
  EXPECT_EQ(learned.status, vision::LearnedColour::Status::kLearned);
  vision::TrackerOptions options;
  options.rig = rig;
  options.colour = {learned.model, learned.model};
  return options;
}

/// Something that a camera may see. `p_L`: in the left camera's frame.
struct Thing {
  Draw draw;
  Eigen::Vector3d p_L;
};

/// Shows a pair with these things, or none.
inline const vision::TargetReport& look(vision::StereoVision& vision, const StereoRig& rig, int64_t utime,
                                        const std::vector<Thing>& things = {}) {
  cv::Mat left = wall(2), right = wall(3);
  for (const Thing& thing : things) {
    thing.draw(left, rig.left, thing.p_L);
    thing.draw(right, rig.right, rig.X_RL * thing.p_L);
  }
  vision::DecodedImages images({utime, utime, utime}, left, right);
  EXPECT_EQ(vision.update(images), nullptr);
  return vision.targets().front().report;
}

}  // namespace multireach::testing
