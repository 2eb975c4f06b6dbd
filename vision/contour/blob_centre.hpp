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
struct BlobCentre {
  Eigen::Vector2d px{0, 0};                              ///< relative to the point that was given
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of `px`, including `shape_sigma`
  /// Error of `px` by one standard deviation of the object's shape, where the border cuts it off; otherwise 0.
  Eigen::Vector2d shape_sigma{0, 0};
  /// Covariance of `px`, if something may hide up to half of an object as wide as it is long; not in `covariance`.
  Eigen::Matrix2d occlusion_covariance = Eigen::Matrix2d::Zero();
  double radius_px = 0;                     ///< of a disc of the object's area
  bool cut_off = false;                     ///< the blob reaches the border of the readable pixels
  double cut_off_share = 0;                 ///< share of the object's area that is beyond the border
  static constexpr double kNotLocated = 1;  ///< `cut_off_share` where nothing tells where the centre is
};

/// The centre of an object by its blob, with its holes filled. `rows`: the blob's extents in the rows of its `box`. Of
/// an object that the border of the `readable` pixels does not cut off, this is the centroid. Of an ellipse that the
/// border cuts off on one side, the chord along the border and the longest chord parallel to it tell how much is beyond
/// the border; other objects are taken for ellipses. Not located: an object whose centre may lie beyond the border, or
/// that several borders cut off.
BlobCentre centre_of(std::span<const BlobExtent> rows, const cv::Rect& box, const cv::Rect& readable,
                     const Eigen::Vector2d& relative_to);

}  // namespace multireach::vision
