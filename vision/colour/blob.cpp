#include "vision/colour/blob.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace multireach::vision {

void add_alternative(const Blob& other, double probability, Blob& blob) {
  const Eigen::Vector2d apart = other.centroid - blob.centroid;
  blob.alternative_area += probability * other.area;
  blob.alternative_spread += probability * apart * apart.transpose();
}

double compactness(double area, const Eigen::Matrix2d& spread) {
  const double half_trace = 0.5 * spread.trace(), determinant = std::max(0.0, spread.determinant());
  const double root = std::sqrt(std::max(0.0, half_trace * half_trace - determinant));
  const double ellipse = 4 * std::numbers::pi * std::sqrt(determinant);
  if (!(ellipse > 0)) return 0;
  return std::min(1.0, area / ellipse) * std::sqrt((half_trace - root) / (half_trace + root));
}

double compactness(const Blob& blob) {
  return compactness(blob.area, blob.spread);
}

int64_t common_pixels(const Blob& a, const Blob& b) {
  if ((a.box & b.box).empty()) return 0;
  int64_t common = 0;
  for (auto first = a.runs.begin(), second = b.runs.begin(); first != a.runs.end() && second != b.runs.end();) {
    if (first->row == second->row)
      common += std::max(0, std::min(first->end, second->end) - std::max(first->begin, second->begin));
    const bool first_ends = first->row != second->row ? first->row < second->row : first->end < second->end;
    ++(first_ends ? first : second);
  }
  return common;
}

}  // namespace multireach::vision
