#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace multireach::vision {

/// Neighbouring pixels [begin, end) of one row.
struct Run {
  int row = 0, begin = 0, end = 0;
  friend bool operator==(const Run&, const Run&) = default;
};

/// A connected set of pixels of one image. Places are in pixels of the whole image, the centre of its first pixel at
/// (0, 0).
struct Blob {
  std::vector<Run> runs;                             ///< all pixels, in the order of rows, then of columns
  cv::Rect box;                                      ///< the smallest that holds all pixels
  double area = 0;                                   ///< number of pixels; holes are not counted
  Eigen::Vector2d centroid{0, 0};                    ///< mean of the pixels' places; holes have no part in it
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();  ///< covariance of the pixels' places, pixels^2
};

}  // namespace multireach::vision
