#include "imaging/lens.hpp"

#include <Eigen/LU>

namespace multireach {

LensPoint image_of(const CameraModel& camera, const Eigen::Vector2d& ray) {
  const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = camera.distortion;
  const double x = ray.x(), y = ray.y(), r2 = x * x + y * y;
  const double above = 1 + r2 * (k1 + r2 * (k2 + r2 * k3)), below = 1 + r2 * (k4 + r2 * (k5 + r2 * k6));
  const double radial = above / below;
  const double slope =
      ((k1 + r2 * (2 * k2 + r2 * 3 * k3)) - radial * (k4 + r2 * (2 * k5 + r2 * 3 * k6))) / below;  // d radial / d r2
  const Eigen::Vector2d focal(camera.fx, camera.fy);
  LensPoint point;
  point.pixel.x() = camera.fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + camera.cx;
  point.pixel.y() = camera.fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + camera.cy;
  const double across = 2 * (x * y * slope + p1 * x + p2 * y);
  point.d_pixel_d_ray << radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x, across, across,
      radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x;
  point.d_pixel_d_ray = (focal.asDiagonal() * point.d_pixel_d_ray).eval();
  return point;
}

Eigen::Vector2d ray_of(const CameraModel& camera, const Eigen::Vector2d& pixel, const Eigen::Vector2d& near) {
  Eigen::Vector2d ray = near;
  constexpr int kSteps = 20;  // three or four suffice from a start nearby
  for (int step = 0; step < kSteps; ++step) {
    const LensPoint at = image_of(camera, ray);
    const Eigen::Vector2d move = at.d_pixel_d_ray.inverse() * (pixel - at.pixel);
    ray += move;
    if (move.squaredNorm() < 1e-16) break;  // converges quadratically: the next step would be negligible
  }
  return ray;
}

}  // namespace multireach
