#pragma once

#include <Eigen/Geometry>

namespace multireach::controller {

/// An obstacle, in the robot's base frame W.
struct Obstacle {
  enum class Shape {
    kSphere,   ///< size: radius
    kCapsule,  ///< size: radius, length of the axis (along z, without the hemispheres)
    kBox,      ///< size: full lengths along x, y, z
  };
  Shape shape = Shape::kSphere;
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< m

  bool operator==(const Obstacle& other) const {
    return shape == other.shape && X_WO.matrix() == other.X_WO.matrix() && size == other.size;
  }
};

/// Whether all numbers are finite, the rotation matrix is orthonormal, and the sizes that the shape uses are positive
/// and below 1 km. A capsule's axis may have length zero.
[[nodiscard]] bool is_valid(const Obstacle& obstacle);

/// The distance of `p` (m, in W) from the obstacle's surface, negative inside. Writes the unit vector in W that leads
/// away from the surface at `p`.
double signed_distance(const Obstacle& obstacle, const Eigen::Vector3d& p, Eigen::Vector3d& away);

}  // namespace multireach::controller
