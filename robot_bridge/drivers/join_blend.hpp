#pragma once

#include "robot_bridge/motion_limits.hpp"

namespace multireach::drivers {

/// Leads smoothly to commands that begin elsewhere than the arm is, or with another velocity: the difference is added
/// to the commands and falls to zero along a quintic, within half of each joint's velocity, acceleration and jerk
/// limits (the velocity that the difference begins with may be larger).
class JoinBlend {
 public:
  /// `difference`: position and velocity from the first command to the arm; its acceleration does not count.
  JoinBlend(const robot_bridge::MotionLimits& limits, const robot_bridge::MotionState& difference);

  /// Adds what remains after `time_s` to a command.
  void apply(double time_s, robot_bridge::MotionState& command) const;
  bool over(double time_s) const { return time_s >= duration_s_; }

 private:
  bool keeps(const robot_bridge::MotionLimits& limits, int joint) const;

  robot_bridge::MotionState difference_;
  double duration_s_ = 0;
};

}  // namespace multireach::drivers
