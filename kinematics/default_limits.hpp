#pragma once

#include <cmath>

#include "kinematics/joint_vector.hpp"

namespace multireach {

/// Limits where neither the URDF nor the configuration gives any: what the controller plans with and the bridge
/// enforces.

/// Speed limit of such a joint, rad/s or m/s.
inline constexpr double kSpeedWhereUnlimited = 3;
/// Time in which a joint without a configured acceleration limit may reach its speed limit, s.
inline constexpr double kDefaultTimeToSpeed = 0.1;
/// Time in which a joint without a configured jerk limit may reach its acceleration limit, s.
inline constexpr double kDefaultTimeToAcceleration = 0.01;

/// The acceleration limits (rad/s^2 or m/s^2) that follow from the speed limits (rad/s or m/s) of all joints. A joint
/// whose speed limit is 0 does not move; its acceleration limit is that of a joint without a speed limit.
inline JointVector default_acceleration(const JointVector& speed, double speed_where_unlimited = kSpeedWhereUnlimited) {
  JointVector acceleration(speed.size());
  for (Eigen::Index i = 0; i < speed.size(); ++i) {
    const bool given = std::isfinite(speed[i]) && speed[i] > 0;
    acceleration[i] = (given ? speed[i] : speed_where_unlimited) / kDefaultTimeToSpeed;
  }
  return acceleration;
}

}  // namespace multireach
