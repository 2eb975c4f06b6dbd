#pragma once

#include <cstdint>

#include "kinematics/chain.hpp"

namespace multireach::robot_bridge {

/// A joint configuration that the controller wants at one tick.
struct Setpoint {
  int64_t run = 0;    ///< of its sender
  int64_t utime = 0;  ///< nominal time of the controller's tick, microseconds
  int64_t sequence = -1;
  JointVector theta;     ///< rad or m
  JointVector velocity;  ///< rad/s or m/s
};

/// Why a set-point is refused.
enum class SetpointVerdict {
  kAccepted,
  kNotReady,     ///< the bridge is idle or in a fault
  kInvalid,      ///< another number of joints, or not finite
  kOtherRun,     ///< another sender is followed
  kNotNewer,     ///< its time or sequence number is not after that of the last one
  kTooOld,       ///< its time is too far in the past
  kTooEarly,     ///< its time is too far in the future
  kTooFast,      ///< it implies a speed beyond the limits
  kFarFromRobot  ///< the first one of its sender, and the robot is elsewhere or moves
};
inline constexpr int kNumVerdicts = 9;
/// The verdict in words, e.g. "too old".
const char* name_of(SetpointVerdict verdict);

}  // namespace multireach::robot_bridge
