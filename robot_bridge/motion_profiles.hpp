#pragma once

#include "robot_bridge/motion_limits.hpp"

namespace multireach::robot_bridge {

/// Smooth deceleration of one joint to rest, with continuous position, velocity and acceleration: the velocity is a
/// cubic polynomial of time from (v, a) to (0, 0).
struct StopProfile {
  double duration_s = 0;                                ///< 0 at rest
  double position = 0, velocity = 0, acceleration = 0;  ///< at its start

  /// Position, velocity and acceleration after `time_s`; at rest from duration_s on.
  void at(double time_s, double& q, double& v, double& a) const;
};

/// The shortest stop profile found for joint `joint` that keeps its acceleration and jerk limits. `feasible` is false
/// when it breaks the velocity or position limit on its way. A position outside the limits counts as the limit on its
/// side, so that it may not move further out.
StopProfile stop_profile(const MotionLimits& limits, int joint, double position, double velocity, double acceleration,
                         bool& feasible);

/// A motion of all joints over the same time, with quintic polynomials: continuous position, velocity and acceleration
/// at both ends.
class QuinticSegment {
 public:
  QuinticSegment() = default;
  /// From `start` to `end` in `duration_s` > 0.
  QuinticSegment(const MotionState& start, const MotionState& end, double duration_s);

  double duration_s() const { return duration_s_; }
  /// The state after `time_s`, from 0 to duration_s().
  void at(double time_s, MotionState& state) const;
  /// Whether the motion keeps all limits and can be stopped within them at any time (checked every `step_s`, or at
  /// 256 times in a long segment).
  bool keeps(const MotionLimits& limits, double step_s) const;

 private:
  bool keeps_jerk_and_acceleration(const MotionLimits& limits, int joint) const;
  bool is_far_from_limits(const MotionLimits& limits, int joint, int samples) const;
  bool keeps_position_and_velocity(const MotionLimits& limits, int joint, int samples, int stride) const;
  void joint_at(int joint, double s, double& q, double& v, double& a) const;

  double duration_s_ = 0;
  // Coefficients of the position as a polynomial of s = time / duration, one row for each joint.
  Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMaxJoints, 6> coefficients_;
};

}  // namespace multireach::robot_bridge
