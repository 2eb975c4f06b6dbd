#pragma once

#include <span>

#include "imaging/camera_model.hpp"

namespace multireach {

/// The image point of a direction, and its derivative with respect to the direction.
struct LensPoint {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d d_pixel_d_ray;
};

/// Projects the direction (x/z, y/z): `CameraModel::project` with its derivative, from the equations of OpenCV's
/// rational model. Does not allocate. Finite for directions within the validity of the lens model.
LensPoint image_of(const CameraModel& camera, const Eigen::Vector2d& ray);

/// Undistorted viewing ray (x/z, y/z) of a pixel: the inverse of `image_of`, by Newton steps from `near`, which should
/// be the ray of a pixel nearby. Converges to 1e-12 where the lens model is invertible; elsewhere returns the last
/// iterate.
Eigen::Vector2d ray_of(const CameraModel& camera, const Eigen::Vector2d& pixel, const Eigen::Vector2d& near);

/// ray_of() of several pixels, in SIMD lanes: `rays`, as many as `pixels`, holds the start of each and then its ray.
/// The results do not depend on the instruction set.
void rays_of(const CameraModel& camera, std::span<const Eigen::Vector2d> pixels, std::span<Eigen::Vector2d> rays);

}  // namespace multireach
