#pragma once

#include <Eigen/Core>

namespace multireach {

/// Largest number of joints of a chain. Joint vectors and Jacobians reserve this size on the stack, so that a control
/// step does not allocate, whatever the arm.
inline constexpr int kMaxJoints = 16;

/// n joint positions: rad, or metres for a prismatic joint.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;
/// 3 x n: maps joint velocities to the linear velocity of a point.
using PositionJacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxJoints>;
/// 6 x n: maps joint velocities to the linear velocity of a point (rows 0-2) and the angular velocity (rows 3-5).
using PoseJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxJoints>;

}  // namespace multireach
