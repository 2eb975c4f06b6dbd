#pragma once

#include "kinematics/joint_vector.hpp"

namespace multireach::drivers {

enum class FrankaModel { kPanda, kResearch3 };

/// What Franka's robots demand of a stream of set-points, besides the position limits of the URDF.
struct FrankaLimits {
  JointVector acceleration;  ///< rad/s^2
  JointVector jerk;          ///< rad/s^3
};

/// Franka's tables control-parameters-joint of the two models.
FrankaLimits franka_limits(FrankaModel model);

/// Largest speed of the Research 3 at the joint positions `q`, rad/s, in the direction of rising (`upwards`) or falling
/// positions: it falls to 0 towards each position limit. Franka's control parameters, limits for the Franka Research 3;
/// also libfranka's computeUpperLimitsJointVelocity and computeLowerLimitsJointVelocity.
JointVector research3_velocity(const JointVector& q, bool upwards);

}  // namespace multireach::drivers
