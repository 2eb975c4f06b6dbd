#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace multireach::vision {

/// What a picture for people shows of one target.
struct DebugMarks {
  struct Disc {
    Eigen::Vector2d centre_px{0, 0};
    double radius_px = 0;
    bool chosen = false;  ///< it is the target, and not one of the others of its colour
  };
  struct OneSide {
    cv::Rect window;  ///< where it was looked for
    std::vector<Disc> discs;
  };
  std::string text;
  cv::Scalar colour;             ///< BGR
  std::array<OneSide, 2> sides;  ///< left, right
};

/// Both 8-bit BGR images side by side with what was found in them: windows, discs (the chosen one with a cross), and a
/// line of text for each target. Images of different heights are made equal by black rows.
cv::Mat debug_picture(const cv::Mat& left, const cv::Mat& right, const std::vector<DebugMarks>& targets);

}  // namespace multireach::vision
