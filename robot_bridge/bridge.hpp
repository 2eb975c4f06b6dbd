#pragma once

#include <array>
#include <optional>

#include "kinematics/default_limits.hpp"
#include "robot_bridge/guard.hpp"
#include "robot_bridge/interpolate.hpp"
#include "robot_bridge/motion_generator.hpp"
#include "robot_bridge/robot_monitor.hpp"
#include "robot_bridge/setpoint.hpp"

namespace multireach::robot_bridge {

struct BridgeOptions {
  /// How the commands go from one set-point to the next.
  enum class Shape {
    kSmooth,  ///< all limits are kept: position, velocity, acceleration and jerk
    kLinear,  ///< as on the paper's second computer (Sect. 4): only position and velocity limits; real robots are
              ///< refused
  };
  int64_t period_us = 1000;            ///< 1 kHz, Sect. 4
  int64_t setpoint_period_us = 50000;  ///< period of the controller
  int64_t robot_timeout_us = 20000;    ///< without a command for this long, the robot stops by itself
  int64_t delay_us = 5000;             ///< how late a set-point may arrive without affecting the motion
  double speed_where_unlimited = kSpeedWhereUnlimited;  ///< rad/s or m/s, for joints whose URDF gives no speed limit
  JointVector acceleration{}, jerk{};  ///< limits of each joint; empty for the defaults of motion_limits()
  Shape shape = Shape::kSmooth;
  int64_t max_setpoint_age_us = 100000;  ///< an older set-point is refused
  int64_t max_setpoint_lead_us = 60000;  ///< a set-point further in the future is refused
  int64_t setpoint_timeout_us = 500000;  ///< without a set-point for this long, the bridge no longer follows its sender
  double max_start_distance = 0.1;       ///< rad or m: of the first set-point from the robot, in each joint
  MonitorOptions monitor{};
};

/// What the bridge does; docs/safety.md has the table of states and events.
enum class BridgeState {
  kIdle,      ///< disabled, or the robot is unknown: no commands
  kArmed,     ///< at rest, ready to follow the first sender of set-points near the robot
  kRunning,   ///< follows set-points
  kStopping,  ///< decelerates, and resumes by itself when the cause is over
  kFault,     ///< at rest, or decelerating to it, until reset()
};
/// "idle", "armed", ...
const char* name_of(BridgeState state);

struct Command {
  int64_t utime = 0;               ///< nominal time of the tick, microseconds
  int64_t setpoint_sequence = -1;  ///< the set-point of the current segment
  bool holding = false;            ///< no set-point is followed: the robot decelerates or rests
  bool limited = false;            ///< a limit made the motion slower than the set-points
  JointVector theta;               ///< rad or m
  JointVector velocity;            ///< rad/s or m/s
};

/// The bridge as a stage: set-points, measurements and requests in; one command in each period out. Position, velocity,
/// acceleration and jerk of the commands keep their limits for any inputs at any times (but for a gap of more than
/// kBridgedGap periods, in which the robot must stop by itself). Deterministic.
class Bridge {
 public:
  /// Longest gap in the ticks, in periods, after which the motion continues as if there had been none.
  static constexpr int64_t kBridgedGap = 3;

  /// Throws std::invalid_argument for a period, limit or tolerance that is not positive, or a delay that is negative or
  /// longer than three periods of the set-points.
  Bridge(const Chain& chain, const BridgeOptions& options);

  /// Takes what the robot measures. A real robot is disabled until enable(), at first and after each of its restarts.
  /// Returns false, and ignores it, when it is not finite, beyond 1e6, of another size, older than the last, or of
  /// another robot: see RobotMonitor::update(). `verdict` gets why.
  [[nodiscard]] bool measured(const Measurement& measurement, MeasurementVerdict& verdict);
  [[nodiscard]] bool measured(const Measurement& measurement) {
    MeasurementVerdict verdict{};
    return measured(measurement, verdict);
  }
  /// There was a measurement, which is not known any more: a recorder lost it.
  void heard() { monitor_.heard(); }
  /// Takes a set-point, or returns why it is refused. `restarted` is set when the ticks restart at its time.
  [[nodiscard]] SetpointVerdict setpoint(const Setpoint& setpoint, bool& restarted);

  /// Requests from a user. Disabling decelerates first. reset() leaves a fault when states of the robot have arrived
  /// and it is at standstill. After enable() and reset() the bridge is in kIdle until the robot's next state arrives:
  /// it has no other means to know that the robot is still there.
  void enable();
  void disable();
  [[nodiscard]] bool reset();
  /// Sets the speed override, 0 to 1. Others are ignored.
  void set_speed(double speed);
  static constexpr double kMinSpeed = 0.01;  ///< a smaller speed override pauses
  /// Decelerates and waits, or continues at the speed override of before.
  void pause(bool paused) { paused_ = paused; }
  bool paused() const { return paused_; }
  /// With the cause kDoesNotFollow: the joint that was too far from its commands.
  int joint_of_fault() const { return joint_of_fault_; }

  /// The time of the next tick, microseconds; nullopt while no commands are sent.
  std::optional<int64_t> next_tick() const { return next_tick_; }
  /// Computes the next tick. Requires that next_tick() has a value.
  Command tick();
  /// `periods` > 0 ticks were missed: their commands are never sent.
  void skip(int64_t periods);

  BridgeState state() const { return state_; }
  /// Why the bridge is in kStopping or kFault; "" otherwise.
  const char* cause() const { return state_ == BridgeState::kStopping || state_ == BridgeState::kFault ? cause_ : ""; }
  bool enabled() const { return enabled_; }
  /// Progress along the set-points per time, 0 to 1; below 1 where a limit or the speed override slows the motion.
  double path_rate() const { return path_rate_; }
  /// How much of each tick the controller should integrate, so that it does not run ahead: 0 to 1.
  double setpoint_rate() const { return setpoint_rate_; }
  double speed() const { return speed_; }
  /// The run of the robot that the commands are for; 0 before the first motion. It stays the same while commands are
  /// sent: a robot that was restarted meanwhile must not obey the old motion.
  int64_t robot_run() const { return robot_run_; }
  /// The run of the robot whose states are followed; nothing before the first.
  std::optional<int64_t> followed_robot() const {
    return monitor_.knows_robot() ? std::optional(monitor_.run()) : std::nullopt;
  }
  /// False where the robot is real and the shape linear, which keeps no limits of acceleration and jerk.
  bool commands_robot() const {
    return options_.shape != BridgeOptions::Shape::kLinear || !monitor_.knows_robot() || !monitor_.newest().real;
  }
  /// Whether the newest state of the robot reports a fault of its own.
  bool robot_faulted() const { return monitor_.knows_robot() && monitor_.newest().faulted; }
  const MotionLimits& limits() const { return generator_.limits(); }

 private:
  SetpointVerdict start_following(const Setpoint& setpoint, bool& restarted);
  SetpointVerdict judge(const Setpoint& setpoint) const;
  bool is_too_fast(const JointVector& velocity) const;
  void step();
  void watch_robot();
  void follow();
  void move_to(const Setpoint& goal, double speed);
  void fail(const char* cause);
  void decelerate(const char* cause);

  Chain chain_;
  BridgeOptions options_;
  MotionGenerator generator_;
  Interpolator interpolator_;  // Shape::kLinear
  Guard guard_;                // Shape::kLinear
  RobotMonitor monitor_;
  BridgeState state_ = BridgeState::kIdle;
  const char* cause_ = "";
  bool enabled_ = true, paused_ = false;
  int joint_of_fault_ = 0;
  double pace_ = 1;  // the speed factor in effect, which falls gradually
  double speed_ = 1, path_rate_ = 1, setpoint_rate_ = 1;

  std::optional<int64_t> next_tick_;
  std::optional<int64_t> far_since_;  // since this time, the sender that resumes is asked to start again
  int64_t robot_run_ = 0;             // of the robot that is commanded
  int64_t run_ = 0;                   // of the sender of set-points that is followed
  int64_t since_setpoint_us_ = 0;     // since the last accepted set-point
  int mistimed_ = 0;                  // grows with set-points that are too early or too old, falls with accepted ones
  Setpoint newest_, goal_;            // accepted last; the one of the current segment
  std::array<Setpoint, 4> waiting_;
  size_t num_waiting_ = 0;
  bool replans_ = false;      // a gap interrupted the segment
  bool coasted_ = false;      // the segment after goal_ continues at its velocity
  bool approaching_ = false;  // far from the set-points: slow until there
  bool measured_since_gap_ = false;
  JointVector velocity_;  // of the last command
};

}  // namespace multireach::robot_bridge
