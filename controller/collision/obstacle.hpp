#pragma once

#include <Eigen/Geometry>

namespace multireach::controller {

/// Something to keep away from, in the robot's base frame W.
struct Obstacle {
  enum class Shape {
    kSphere,   ///< size: radius
    kCapsule,  ///< size: radius, length of the axis (along z, without the round ends)
    kBox,      ///< size: full lengths along x, y, z
  };
  Shape shape = Shape::kSphere;
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< m
};

/// Whether all numbers are finite, the sizes that count are positive (a capsule's axis may have no length) and below
/// 1 km, and the pose is one.
bool acceptable(const Obstacle& obstacle);

/// How far `p` (m, in W) is outside the obstacle's surface, negative inside, and the unit vector in W that leads away
/// from it there.
double signed_distance(const Obstacle& obstacle, const Eigen::Vector3d& p, Eigen::Vector3d& away);

}  // namespace multireach::controller
