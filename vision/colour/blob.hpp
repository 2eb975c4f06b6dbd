#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace multireach::vision {

/// A run of adjacent pixels in one row: columns [begin, end).
struct Run {
  int row = 0, begin = 0, end = 0;
  friend bool operator==(const Run&, const Run&) = default;
};

/// A connected component of pixels of one image. Positions are in pixels of the whole image, with the centre of the
/// first pixel at (0, 0).
struct Blob {
  std::vector<Run> runs;                             ///< all pixels, ordered by row, then by column
  cv::Rect box;                                      ///< bounding box
  double area = 0;                                   ///< number of pixels, without holes
  Eigen::Vector2d centroid{0, 0};                    ///< mean of the pixels' positions, without holes
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();  ///< covariance of the pixels' positions, pixels^2
  /// Of what the object may be instead: the union with adjacent blobs, if this may be a part of a larger object; one of
  /// its parts, each as likely as its share of the area, if this is such a union (join_parts); what it was grown from
  /// (grow_blobs). Mean number of pixels, 0 if there is nothing, and mean of the outer products of what is from this
  /// centroid to that one, pixels^2.
  double alternative_area = 0;
  Eigen::Matrix2d alternative_spread = Eigen::Matrix2d::Zero();
};

/// Adds to `blob` that the object may be another blob instead, with this probability.
void add_alternative(const Blob& other, double probability, Blob& blob);

/// How much a shape resembles a disc: 1 for a disc, less for an ellipse and for a ragged shape. The ratio of the axes
/// of the ellipse with the shape's moments, times the share of this ellipse that the shape fills. `area`: pixels;
/// `spread`: covariance of their positions, pixels^2.
double compactness(double area, const Eigen::Matrix2d& spread);
double compactness(const Blob& blob);

/// Number of pixels that two blobs of one image have in common.
int64_t common_pixels(const Blob& a, const Blob& b);

}  // namespace multireach::vision
