#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

namespace multireach::vision {

/// A connected region of a mask, its holes (highlights) filled.
struct Blob {
  Eigen::Vector2d centroid;   ///< pixels, centre of the first pixel at (0, 0)
  double area = 0;            ///< pixels
  bool cut_off = false;       ///< touches the border of the image, so its centroid is not the object's
};

/// The largest blob of an 8-bit mask, after specks thinner than three pixels are removed; nothing when its area is below
/// `min_area` pixels.
std::optional<Blob> largest_blob(const cv::Mat& mask, double min_area);

}  // namespace multireach::vision
