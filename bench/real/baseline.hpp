#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace multireach::bench {

/// The usual OpenCV baseline for a coloured object: HSV, inRange (the clicked hue within 10 of 180, at least half the
/// clicked saturation and value), opening by 5 x 5, the largest contours, their moments.
class Baseline {
 public:
  Baseline(const cv::Mat& bgr, const cv::Point& click);
  /// Takes the limits of another click as well: everything from the lower ones to the higher ones.
  void widen(const Baseline& other);
  /// The centres of the `most` largest contours.
  std::vector<cv::Point2d> find(const cv::Mat& bgr, size_t most = 1) const;

 private:
  /// Turns the hues so that the clicked one is in the middle: red is at both ends.
  void turn(cv::Mat& hsv) const;

  int clicked_hue_ = 0;
  cv::Scalar low_, high_;
};

}  // namespace multireach::bench
