#include "imaging/camera_model.hpp"

#include <Eigen/Geometry>

#include "imaging/lens.hpp"

namespace multireach {

Eigen::Vector2d CameraModel::project(const Eigen::Vector3d& p_C) const {
  return image_of(*this, p_C.hnormalized()).pixel;
}

Eigen::Vector2d CameraModel::ray(const Eigen::Vector2d& pixel) const {
  // Newton's method needs a start nearby: the pinhole camera's direction, brought nearer by steps that divide the
  // distortion out, for as long as they help.
  constexpr int kSteps = 10;
  const Eigen::Array2d focal(fx, fy), centre(cx, cy);
  const auto distorted_from = [&](const Eigen::Vector2d& ray) -> Eigen::Vector2d {
    return ((image_of(*this, ray).pixel.array() - centre) / focal).matrix();
  };
  const Eigen::Vector2d distorted = ((pixel.array() - centre) / focal).matrix();
  Eigen::Vector2d ray = distorted, missing = distorted - distorted_from(ray);
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::Vector2d next = ray + missing, next_missing = distorted - distorted_from(next);
    if (!(next_missing.squaredNorm() < missing.squaredNorm())) break;
    ray = next;
    missing = next_missing;
  }
  return ray_of(*this, pixel, ray);
}

std::vector<Eigen::Vector2d> CameraModel::rays(const std::vector<Eigen::Vector2d>& pixels) const {
  std::vector<Eigen::Vector2d> result;
  result.reserve(pixels.size());
  for (const Eigen::Vector2d& pixel : pixels) result.push_back(ray(pixel));
  return result;
}

}  // namespace multireach
