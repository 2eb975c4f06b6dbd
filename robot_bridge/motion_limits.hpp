#pragma once

#include "kinematics/chain.hpp"

namespace multireach::robot_bridge {

/// Position, velocity and acceleration of all joints: rad, rad/s, rad/s^2, or m, m/s, m/s^2 for a prismatic joint.
struct MotionState {
  JointVector position, velocity, acceleration;

  static MotionState at_rest(const JointVector& position) {
    return {position, JointVector::Zero(position.size()), JointVector::Zero(position.size())};
  }
};

/// Limits of each joint's motion, symmetric but for the position. All are positive and, but for the position of a
/// continuous joint, finite.
struct MotionLimits {
  JointVector lower, upper;  ///< rad or m; infinite for a continuous joint
  JointVector velocity;      ///< rad/s or m/s
  JointVector acceleration;  ///< rad/s^2 or m/s^2
  JointVector jerk;          ///< rad/s^3 or m/s^3
};

/// The limits of the chain's joints. `speed_where_unlimited` (rad/s or m/s) holds for joints without a speed limit;
/// `acceleration` and `jerk` have size() elements or none, where those of kinematics/default_limits.hpp hold. Throws
/// std::invalid_argument when a value is not positive and finite, or a size differs.
MotionLimits motion_limits(const Chain& chain, double speed_where_unlimited, const JointVector& acceleration,
                           const JointVector& jerk);

}  // namespace multireach::robot_bridge
