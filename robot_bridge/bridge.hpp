#pragma once

#include <optional>

#include "robot_bridge/guard.hpp"
#include "robot_bridge/interpolate.hpp"

namespace multireach::robot_bridge {

struct BridgeOptions {
  int64_t period_us = 1000;            ///< 1 kHz, Sect. 4
  int64_t setpoint_period_us = 50000;  ///< the controller's
  int64_t delay_us = 10000;            ///< how late a set-point may come without being felt
  double speed_where_unlimited = 3;    ///< rad/s or m/s, for joints whose URDF gives no speed limit
};

struct Command {
  int64_t utime = 0;               ///< nominal time of the tick, microseconds
  int64_t setpoint_sequence = -1;  ///< the set-point that is being approached
  bool holding = false;
  bool limited = false;
  JointVector theta;     ///< rad or m
  JointVector velocity;  ///< rad/s or m/s: of this tick's step
};

/// The bridge as a stage. Silent until it knows where the robot is and has its first set-point; then one command a
/// tick, for ever: when set-points stop it holds the last one.
class Bridge {
 public:
  /// Throws std::invalid_argument for periods or speeds that are not positive, or a delay that is negative or
  /// longer than three periods of the set-points.
  Bridge(const Chain& chain, const BridgeOptions& options);

  /// The robot's posture, taken as the start of the motion until the first set-point has come. Returns false when it is
  /// not finite, beyond 1e6 rad or m, or of another size.
  bool measured(const JointVector& theta);
  bool knows_robot() const { return position_.has_value(); }
  /// Returns false, and ignores the set-point, when it is not finite, beyond 1e6 rad or m, of another size, or the
  /// robot is not known. A set-point whose time does not fit by more than a second starts the grid again at its time.
  bool setpoint(const Setpoint& setpoint);
  /// The time of the next tick; nothing before the first set-point.
  std::optional<int64_t> next_tick() const { return next_tick_; }
  /// Computes the next tick. Needs next_tick().
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
