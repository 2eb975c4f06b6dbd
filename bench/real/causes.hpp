#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "vision/stereo_vision.hpp"

namespace multireach::bench {

/// Distances from a label, pixels: answers within the first are right, beyond the second wrong.
inline constexpr double kRight = 10, kWrong = 25;

/// Why labelled images have no right answer.
class Causes {
 public:
  /// Takes an image without a right answer. `disparity_px`: columns by which the second image is shifted.
  void add(const vision::StereoVision::Target& target, const std::vector<cv::Point2d>& labels, int disparity_px);
  void add(const Causes& other);
  /// Prints lines of a table: cause, per cent of `labelled` images.
  void print(const std::string& set, const std::string& object, int labelled) const;

 private:
  std::map<std::string, int> images_;
};

}  // namespace multireach::bench
