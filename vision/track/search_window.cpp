#include "vision/track/search_window.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::vision {

std::optional<cv::Rect> search_window(const CameraModel& camera, const Eigen::Vector3d& p_C,
                                      const Eigen::Matrix3d& covariance, const WindowSize& size) {
  constexpr double kSigmas = 2.5;
  // The maximum row sum bounds the largest eigenvalue, so sigma_m bounds the standard deviation in every direction.
  const double sigma_m = std::sqrt(covariance.cwiseAbs().rowwise().sum().maxCoeff());
  const double near = p_C.z() - size.nearer_m - kSigmas * sigma_m;
  if (!(near > size.least_z_m)) return std::nullopt;
  const double half = std::max(camera.fx, camera.fy) * (size.around_m + kSigmas * sigma_m) / near + size.margin_px;
  const Eigen::Vector2d centre = camera.project(p_C);
  if (!(centre.cwiseAbs().maxCoeff() < 1e5 && half < 1e5)) return std::nullopt;
  const auto first = [&](double at) { return static_cast<int>(std::floor(at - half)); };
  const int side = static_cast<int>(std::ceil(2 * half)) + 1;
  return cv::Rect(first(centre.x()), first(centre.y()), side, side);
}

}  // namespace multireach::vision
