#pragma once

#include <optional>

#include "robot_bridge/guard.hpp"
#include "robot_bridge/interpolate.hpp"

namespace multireach::robot_bridge {

struct BridgeOptions {
  int64_t period_us = 1000;            ///< 1 kHz, Sect. 4
  int64_t setpoint_period_us = 50000;  ///< period of the controller
  int64_t delay_us = 10000;            ///< how late a set-point may arrive without affecting the motion
  double speed_where_unlimited = 3;    ///< rad/s or m/s, for joints whose URDF gives no speed limit
};

struct Command {
  int64_t utime = 0;               ///< nominal time of the tick, microseconds
  int64_t setpoint_sequence = -1;  ///< the set-point of the current segment
  bool holding = false;            ///< whether the segment is complete and no later set-point has come
  bool limited = false;            ///< whether the guard changed the interpolated position
  JointVector theta;               ///< rad or m
  JointVector velocity;            ///< rad/s or m/s, from the previous command to this one
};

/// The bridge as a stage. It sends nothing until it has the robot's joint positions and a first set-point. From then on
/// it computes one command per tick; when set-points stop, it completes the current segment, then holds.
class Bridge {
 public:
  /// Throws std::invalid_argument for periods or speeds that are not positive, or a delay that is negative or
  /// longer than three periods of the set-points.
  Bridge(const Chain& chain, const BridgeOptions& options);

  /// Takes the robot's measured joint positions. Before the first set-point they are the start of the motion;
  /// afterwards they have no effect. Returns false when they are not finite, beyond 1e6 rad or m, or have another size.
  bool measured(const JointVector& theta);
  bool knows_robot() const { return position_.has_value(); }
  /// Takes a set-point. Returns false, and ignores it, when it is not finite, beyond 1e6 rad or m, has another size or
  /// is not newer than the last, or when the robot's joint positions are unknown. A set-point whose time differs from
  /// the next tick by more than a second restarts the ticks at its time.
  bool setpoint(const Setpoint& setpoint);
  /// The time of the next tick; nullopt before the first set-point.
  std::optional<int64_t> next_tick() const { return next_tick_; }
  /// Computes the next tick. Requires that next_tick() has a value.
  Command tick();

 private:
  bool sensible(const JointVector& theta) const;

  Chain chain_;
  BridgeOptions options_;
  Interpolator interpolator_;
  Guard guard_;
  std::optional<JointVector> position_;
  std::optional<int64_t> next_tick_;
};

}  // namespace multireach::robot_bridge
