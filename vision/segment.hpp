#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace multireach::vision {

// Apart from the Blob of vision/blob.hpp, which replaces it.
inline namespace outlined {

/// A connected region of a mask, its holes (highlights) filled.
struct OutlinedBlob {
  Eigen::Vector2d centroid;              ///< pixels, centre of the first pixel at (0, 0)
  std::vector<Eigen::Vector2d> outline;  ///< centres of the pixels on its border, in order
  double area = 0;                       ///< pixels
  bool cut_off = false;                  ///< touches the border of the image, so its centroid is not the object's
};

}  // namespace outlined

/// The centroid of the area inside a closed polygon; nothing when it has no area.
std::optional<Eigen::Vector2d> polygon_centroid(const std::vector<Eigen::Vector2d>& polygon);

/// The largest blob of an 8-bit mask, after specks thinner than three pixels are removed; nothing when its area is
/// below `min_area` pixels.
std::optional<OutlinedBlob> largest_blob(const cv::Mat& mask, double min_area);

}  // namespace multireach::vision
