#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace multireach::vision {

/// What a debug picture shows of one target.
struct DebugMarks {
  struct Contour {
    Eigen::Vector2d centre_px{0, 0};
    double radius_px = 0;
    bool chosen = false;  ///< it was matched as the target; false for other objects of its colour
  };
  struct OneSide {
    cv::Rect window;  ///< search window
    std::vector<Contour> contours{};
    std::vector<std::array<Eigen::Vector2d, 4>> outlines{};  ///< of tags: corners, pixels
  };
  std::string text;
  cv::Scalar colour;             ///< BGR
  std::array<OneSide, 2> sides;  ///< left, right
};

/// Draws both 8-bit BGR images side by side with the search windows, the contours (the chosen one with a cross) and a
/// line of text for each target. A lower image is padded with black rows.
cv::Mat debug_picture(const cv::Mat& left, const cv::Mat& right, const std::vector<DebugMarks>& targets);

}  // namespace multireach::vision
