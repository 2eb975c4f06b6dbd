#pragma once

#include "imaging/camera_model.hpp"

namespace multireach {

/// Where a direction is seen, and how that place changes with the direction.
struct LensPoint {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d d_pixel_d_ray;
};

/// The image of the direction (x/z, y/z): `CameraModel::project` with its derivative, from the equations of OpenCV's
/// rational model, without memory or calls of its own. Finite for the directions that the lens model is made for.
LensPoint image_of(const CameraModel& camera, const Eigen::Vector2d& ray);

/// The direction (x/z, y/z) from which the light of a pixel comes: the inverse of `image_of`, by Newton's steps from
/// the direction `near`, which is to be that of a pixel nearby. Converges to 1e-12 where the lens model can be
/// inverted; else the last step's result.
Eigen::Vector2d ray_of(const CameraModel& camera, const Eigen::Vector2d& pixel, const Eigen::Vector2d& near);

}  // namespace multireach
