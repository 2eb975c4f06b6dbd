#pragma once

#include <array>

#include "robot_bridge/motion_profiles.hpp"

namespace multireach::drivers {

/// The deceleration with which a driver ends a motion whose commands stopped coming: each joint to rest within its
/// acceleration and jerk limits.
class StopRamp {
 public:
  /// `state`: at the beginning of the deceleration.
  StopRamp(const robot_bridge::MotionLimits& limits, const robot_bridge::MotionState& state) : state_(state) {
    for (int i = 0; i < state.position.size(); ++i) {
      bool feasible = false;  // there is nothing better to do where it is not
      stops_[static_cast<size_t>(i)] =
          robot_bridge::stop_profile(limits, i, state.position[i], state.velocity[i], state.acceleration[i], feasible);
    }
  }

  /// Advances to `time_s` since the beginning.
  const robot_bridge::MotionState& at(double time_s) {
    for (int i = 0; i < state_.position.size(); ++i) {
      stops_[static_cast<size_t>(i)].at(time_s, state_.position[i], state_.velocity[i], state_.acceleration[i]);
    }
    return state_;
  }
  bool at_rest() const { return state_.velocity.isZero(0) && state_.acceleration.isZero(0); }

 private:
  robot_bridge::MotionState state_;
  std::array<robot_bridge::StopProfile, kMaxJoints> stops_;
};

}  // namespace multireach::drivers
