#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace multireach::bench {

/// The usual OpenCV baseline for a coloured object: HSV, inRange (the clicked hue within 10 of 180, at least half the
/// clicked saturation and value), opening by 5 x 5, the largest contours, their moments.
class Baseline {
 public:
  struct Contour {
    cv::Point2d centre;
    double area_px = 0;
  };

  Baseline(const cv::Mat& bgr, const cv::Point& click);
  /// Takes the limits of another click as well: everything from the lower ones to the higher ones.
  void widen(const Baseline& other);
  /// All contours, the largest first.
  std::vector<Contour> contours(const cv::Mat& bgr) const;

 private:
  /// Turns the hues so that the clicked one is in the middle: red is at both ends.
  void turn(cv::Mat& hsv) const;

  int clicked_hue_ = 0;
  cv::Scalar low_, high_;
};

/// The centres of the `most` first contours.
std::vector<cv::Point2d> largest(const std::vector<Baseline::Contour>& contours, size_t most);

}  // namespace multireach::bench
