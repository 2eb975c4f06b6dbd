#include "vision/track/search_region.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace multireach::vision {
namespace {

constexpr int kSamples = 80;  // rays along each side of the image
constexpr double kMargin = 0.25;
constexpr double kSigmas = 3;

/// Whether a ray from `origin` enters the box, by the intervals in which it is between each pair of faces.
bool enters(const SearchRegion& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  double from = 0, to = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(direction[axis]) < 1e-12) {
      if (origin[axis] < box.min()[axis] || origin[axis] > box.max()[axis]) return false;
      continue;
    }
    const double a = (box.min()[axis] - origin[axis]) / direction[axis];
    const double b = (box.max()[axis] - origin[axis]) / direction[axis];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return from <= to;
}

/// The box, larger by what lies between two rays at its farthest corner, so that no ray misses it.
SearchRegion enlarged(const SearchRegion& region, const Eigen::Vector3d& origin, double apart) {
  const double farthest = ((region.min() - origin).cwiseAbs().cwiseMax((region.max() - origin).cwiseAbs())).norm();
  const Eigen::Vector3d more = Eigen::Vector3d::Constant(apart * farthest);
  return {region.min() - more, region.max() + more};
}

}  // namespace

cv::Rect search_area(const SearchRegion& region, const CameraModel& camera, const Eigen::Isometry3d& X_CW) {
  const double columns = (camera.width - 1.0) / (kSamples - 1), rows = (camera.height - 1.0) / (kSamples - 1);
  std::vector<Eigen::Vector2d> pixels;
  for (int row = 0; row < kSamples; ++row) {
    for (int column = 0; column < kSamples; ++column) pixels.emplace_back(column * columns, row * rows);
  }
  const std::vector<Eigen::Vector2d> rays = camera.rays(pixels);
  const Eigen::Isometry3d X_WC = X_CW.inverse();
  double apart = 0;  // largest distance between neighbouring rays: with a lens, at the border
  for (size_t k = 0; k < rays.size(); ++k) {
    if (k % kSamples > 0) apart = std::max(apart, (rays[k] - rays[k - 1]).norm());
    if (k >= kSamples) apart = std::max(apart, (rays[k] - rays[k - kSamples]).norm());
  }
  const SearchRegion box = enlarged(region, X_WC.translation(), apart);
  cv::Rect seen;
  for (size_t k = 0; k < rays.size(); ++k) {
    if (!enters(box, X_WC.translation(), X_WC.linear() * rays[k].homogeneous())) continue;
    seen |= cv::Rect(static_cast<int>(pixels[k].x()), static_cast<int>(pixels[k].y()), 1, 1);
  }
  if (seen.empty()) return seen;
  const cv::Point margin(static_cast<int>(kMargin * seen.width), static_cast<int>(kMargin * seen.height));
  return cv::Rect(seen.tl() - margin, seen.br() + margin) & cv::Rect(0, 0, camera.width, camera.height);
}

bool may_be_inside(const SearchRegion& region, const Eigen::Vector3d& p_W, const Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d reach = kSigmas * covariance.diagonal().cwiseSqrt();
  return ((p_W + reach).array() >= region.min().array()).all() && ((p_W - reach).array() <= region.max().array()).all();
}

}  // namespace multireach::vision
