#include "vision/contour/blob_centroid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "numeric/trigonometry.hpp"

namespace multireach::vision {
namespace {

// The centroid is the object's centre to within about a tenth of its half axes (twice the root of the second moment
// each) and half a pixel.
constexpr double kShare = 0.2, kBorder = 0.5;
// Where a part is beyond the border, the object's width is its height to within about so much.
constexpr double kAspect = 0.3;

/// Share of a disc's area beyond a line at `distance` radii from its centre.
double share_beyond(double distance) {
  const double d = std::clamp(distance, -1.0, 1.0);
  return (arc_cosine(d) - d * std::sqrt(1 - d * d)) / std::numbers::pi;
}

/// Completes an object along the axis (0: x, 1: y) at one end of which the border cuts it off. `middle`: of what is
/// seen.
void complete(int axis, double seen, double across, bool at_end, double middle, BlobCentroid& result) {
  const double radius = 0.5 * std::max(seen, across);
  const double beyond = 2 * radius - seen, direction = at_end ? 1 : -1;
  result.radius_px = radius;
  result.cut_off_share = beyond < radius ? share_beyond((radius - beyond) / radius) : 1;
  result.centre[axis] = middle + 0.5 * direction * beyond;
  result.from_aspect[axis] = direction * kAspect * radius;
  const double as_centroid = 0.5 * kShare * radius;
  result.covariance.row(axis).setZero();
  result.covariance.col(axis).setZero();
  result.covariance(axis, axis) = result.from_aspect.squaredNorm() + as_centroid * as_centroid + kBorder * kBorder;
}

}  // namespace

BlobCentroid centroid_of(std::span<const BlobExtent> rows, const cv::Rect& box, const cv::Rect& readable,
                         const Eigen::Vector2d& relative_to) {
  double area = 0;
  Eigen::Vector2d sum(0, 0);
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
  for (int k = 0; k < box.height; ++k) {
    const BlobExtent& row = rows[static_cast<size_t>(k)];
    const double length = row.end - row.begin;
    if (length <= 0) continue;
    const double x = 0.5 * (row.begin + row.end - 1) - relative_to.x(), y = box.y + k - relative_to.y();
    area += length;
    sum += length * Eigen::Vector2d(x, y);
    second(0, 0) += length * (x * x + length * length / 12);
    second(0, 1) += length * x * y;
    second(1, 1) += length * (y * y + 1.0 / 12);
  }
  second(1, 0) = second(0, 1);
  BlobCentroid result;
  result.centre = sum / area;
  second = second / area - result.centre * result.centre.transpose();
  result.covariance = kShare * kShare * second + kBorder * kBorder * Eigen::Matrix2d::Identity();
  result.radius_px = std::sqrt(area / std::numbers::pi);

  const bool left = box.x == readable.x, right = box.br().x == readable.br().x;
  const bool top = box.y == readable.y, bottom = box.br().y == readable.br().y;
  const int sides = left + right + top + bottom;
  result.cut_off = sides > 0;
  if (sides > 1) result.cut_off_share = 1;
  if (sides != 1) return result;
  const Eigen::Vector2d middle =
      Eigen::Vector2d(box.x + 0.5 * (box.width - 1), box.y + 0.5 * (box.height - 1)) - relative_to;
  if (left || right) {
    complete(0, box.width, box.height, right, middle.x(), result);
  } else {
    complete(1, box.height, box.width, bottom, middle.y(), result);
  }
  return result;
}

}  // namespace multireach::vision
