#pragma once

#include <array>
#include <cstdint>

#include "robot_bridge/motion_profiles.hpp"

namespace multireach::robot_bridge {

/// Generates a motion that keeps the position, velocity, acceleration and jerk limits of all joints, whatever goals it
/// gets: it starts only segments that keep them and from which it can stop within them at any time. Where the goal
/// cannot be reached in time, all joints take longer together.
class MotionGenerator {
 public:
  /// `period_s`: time from one command to the next.
  MotionGenerator(const MotionLimits& limits, double period_s) : limits_(limits), period_s_(period_s) {}

  /// Discards all motion and rests at `position`.
  void rest_at(const JointVector& position);
  /// Starts to move from the current state to `goal`, which it reaches after `duration_s`, or later where the limits
  /// require it; the goal's velocity and acceleration are then scaled to the longer duration. Returns `duration_s`
  /// divided by the duration of the motion; 0 when no motion keeps the limits: it then goes on as before.
  double move_to(const MotionState& goal, double duration_s);
  /// Starts to decelerate: each joint to rest, as fast as its acceleration and jerk limits allow.
  void stop();
  /// Advances by one period.
  void advance();

  const MotionState& state() const { return state_; }
  /// Whether the segment is complete, or the arm has come to rest.
  bool finished() const { return ticks_ >= duration_ticks_; }
  bool at_rest() const { return finished() && state_.velocity.isZero(0) && state_.acceleration.isZero(0); }
  const MotionLimits& limits() const { return limits_; }

 private:
  MotionLimits limits_;
  double period_s_;
  MotionState state_;
  QuinticSegment segment_;
  std::array<StopProfile, kMaxJoints> stops_;
  bool stopping_ = false;
  // Since the start of the segment or of the stop. A segment takes a whole number of periods: the next one begins
  // exactly where it ends.
  int64_t ticks_ = 0, duration_ticks_ = 0;
};

}  // namespace multireach::robot_bridge
