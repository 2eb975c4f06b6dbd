#pragma once

#include <Eigen/Core>

namespace multireach {

/// Most joints that a chain may have. Vectors and Jacobians of joints keep this much room on the stack, so that nothing
/// in a control step allocates, whatever the arm.
inline constexpr int kMaxJoints = 16;

/// n joint coordinates: rad, or metres for a prismatic joint.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;
/// 3 x n: velocity of a point over joint velocities.
using PositionJacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxJoints>;
/// 6 x n: linear velocity of a point (rows 0-2) and angular velocity (rows 3-5) over joint velocities.
using PoseJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxJoints>;

}  // namespace multireach
