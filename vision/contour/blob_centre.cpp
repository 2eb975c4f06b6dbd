#include "vision/contour/blob_centre.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "numeric/trigonometry.hpp"

namespace multireach::vision {
namespace {

// The centroid is the object's centre to within about a tenth of its half axes (twice the root of the second moment
// each) and half a pixel.
constexpr double kShare = 0.2, kPixel = 0.5;
// Error of a ratio of chords that stands for another shape than an ellipse. With it, the errors of superellipses from a
// diamond to a box (exponents 1 to 8) of which up to a third is beyond the border are within 1.3 standard deviations.
constexpr double kOtherShape = 0.2;

/// An ellipse that a straight border cuts off.
struct CutEllipse {
  double beyond = 0;  // share of its area that is beyond the border
  double shift = 0;   // from the centroid of the rest to the centre, towards the border

  /// `chords`: the chord along the border, as a share of the longest one parallel to it, which is on the side that is
  /// seen. `seen`: how far that side reaches from the border.
  CutEllipse(double chords, double seen) {
    const double chord = std::clamp(chords, 0.0, 1.0), distance = std::sqrt(1 - chord * chord);  // in half axes
    beyond = (arc_cosine(distance) - distance * chord) / std::numbers::pi;
    const double half_axis = seen / (1 + distance);
    shift = half_axis * 2 / 3 * chord * chord * chord / (std::numbers::pi * (1 - beyond));
  }
};

/// BlobCentre::occlusion_covariance of a blob with these central second moments. Half of a disc or of a square lacks
/// about as much of its length as its centre is to its side: two standard deviations. The occluded part is at most the
/// half.
Eigen::Matrix2d occlusion_covariance(const Eigen::Matrix2d& second) {
  const double half_trace = 0.5 * second.trace();
  const double root = std::sqrt(std::max(0.0, half_trace * half_trace - second.determinant()));
  if (!(root > 0)) return Eigen::Matrix2d::Zero();
  const double longer = 2 * std::sqrt(half_trace + root), shorter = 2 * std::sqrt(std::max(0.0, half_trace - root));
  const double sigma = 0.5 * std::min(longer - shorter, shorter);
  const Eigen::Matrix2d across = ((half_trace + root) * Eigen::Matrix2d::Identity() - second) / (2 * root);
  return sigma * sigma * across;
}

/// Number of the blob's pixels in each of the columns of its box.
std::vector<int> column_lengths(std::span<const BlobExtent> rows, const cv::Rect& box) {
  std::vector<int> change(static_cast<size_t>(box.width) + 1);
  for (const BlobExtent& row : rows) {
    if (row.end <= row.begin) continue;
    ++change[static_cast<size_t>(row.begin - box.x)];
    --change[static_cast<size_t>(row.end - box.x)];
  }
  for (size_t k = 1; k < change.size(); ++k) change[k] += change[k - 1];
  change.pop_back();
  return change;
}

std::vector<int> row_lengths(std::span<const BlobExtent> rows) {
  std::vector<int> lengths;
  for (const BlobExtent& row : rows) lengths.push_back(std::max(0, row.end - row.begin));
  return lengths;
}

/// Completes an object along the axis (0: x, 1: y) at one end of which the border cuts it off. `chords`: the blob's
/// lengths along the border, at each position on the axis. `second`: the blob's central second moments.
void complete(int axis, const std::vector<int>& chords, bool at_end, const Eigen::Matrix2d& second,
              BlobCentre& result) {
  const double longest = *std::ranges::max_element(chords), at_border = at_end ? chords.back() : chords.front();
  const double ratio = at_border / longest, seen = static_cast<double>(chords.size());
  const CutEllipse ellipse(ratio, seen), more(ratio + kOtherShape, seen), less(ratio - kOtherShape, seen);
  // The middles of an ellipse's parallel chords are on a line through its centre.
  Eigen::Vector2d direction;
  direction[axis] = at_end ? 1 : -1;
  direction[1 - axis] = direction[axis] * second(0, 1) / second(axis, axis);
  result.px += ellipse.shift * direction;
  result.shape_sigma = 0.5 * (more.shift - less.shift) * direction;
  result.covariance += result.shape_sigma * result.shape_sigma.transpose();
  result.radius_px /= std::sqrt(1 - ellipse.beyond);
  // The lengths of single chords are noisy: where the longest is about as near to the border as that noise, the centre
  // may be beyond it.
  constexpr std::ptrdiff_t kNear = 2;  // pixels
  const std::ptrdiff_t inside = at_end ? std::ranges::max_element(chords.rbegin(), chords.rend()) - chords.rbegin()
                                       : std::ranges::max_element(chords) - chords.begin();
  result.cut_off_share = inside < kNear ? BlobCentre::kNotLocated : ellipse.beyond;
}

}  // namespace

BlobCentre centre_of(std::span<const BlobExtent> rows, const cv::Rect& box, const cv::Rect& readable,
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
  BlobCentre result;
  result.px = sum / area;
  second = second / area - result.px * result.px.transpose();
  result.covariance = kShare * kShare * second + kPixel * kPixel * Eigen::Matrix2d::Identity();
  result.occlusion_covariance = occlusion_covariance(second);
  result.radius_px = std::sqrt(area / std::numbers::pi);

  const bool left = box.x == readable.x, right = box.br().x == readable.br().x;
  const bool top = box.y == readable.y, bottom = box.br().y == readable.br().y;
  const int sides = left + right + top + bottom;
  result.cut_off = sides > 0;
  if (sides > 1) {
    result.cut_off_share = BlobCentre::kNotLocated;
  } else if (left || right) {
    complete(0, column_lengths(rows, box), right, second, result);
  } else if (top || bottom) {
    complete(1, row_lengths(rows), bottom, second, result);
  }
  if (result.cut_off_share == BlobCentre::kNotLocated) {
    const Eigen::Vector2d seen(box.width, box.height);
    result.covariance.diagonal() += seen.cwiseAbs2();
  }
  return result;
}

}  // namespace multireach::vision
