#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <span>

namespace multireach::vision {

/// Range [begin, end) of a blob in a row or column; empty when end <= begin.
struct BlobExtent {
  int begin, end;
};

/// Where an object is in an image, by its blob only.
struct BlobCentroid {
  Eigen::Vector2d centre{0, 0};                          ///< pixels, relative to the point that was given
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of `centre`, px^2
  /// Error of `centre` by one standard deviation of the object's aspect ratio, px; 0 where it is not cut off.
  Eigen::Vector2d from_aspect{0, 0};
  double radius_px = 0;      ///< rough
  bool cut_off = false;      ///< the blob reaches the border of the readable pixels
  double cut_off_share = 0;  ///< share of the object's area that is beyond the border
};

/// The centroid of a blob, with its holes filled. `rows`: the blob's extent in each row of its `box`. Where the border
/// of the `readable` pixels cuts the object off on one side, it is taken to be about as wide as it is high, which tells
/// where its centre is, less certainly. Beyond the border, or cut off on several sides, it is not located:
/// `cut_off_share` is 1.
BlobCentroid centroid_of(std::span<const BlobExtent> rows, const cv::Rect& box, const cv::Rect& readable,
                         const Eigen::Vector2d& relative_to);

}  // namespace multireach::vision
