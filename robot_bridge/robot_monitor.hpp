#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "robot_bridge/motion_limits.hpp"

namespace multireach::robot_bridge {

/// What a robot measures.
struct Measurement {
  int64_t run = 0;       ///< of the robot
  int64_t utime = 0;     ///< the robot's own time, microseconds
  JointVector theta;     ///< rad or m
  JointVector velocity;  ///< rad/s or m/s
  bool real = false;     ///< not simulated
  bool faulted = false;  ///< it does not follow commands
};

struct MonitorOptions {
  double max_tracking_error = 0.3;    ///< rad or m: largest distance of a joint from the recent commands
  int64_t state_timeout_us = 100000;  ///< without a measurement for this long, the motion stops
  int64_t robot_lost_us = 1000000;    ///< without one for this long, the robot counts as lost
};

/// Why a measurement is refused.
enum class MeasurementVerdict {
  kAccepted,
  kInvalid,    ///< another number of joints, or not finite
  kOlder,      ///< it comes after a newer one of the same robot
  kOtherRobot  ///< another robot is followed
};

/// The fault where the robot reports one of its own.
inline constexpr const char* kRobotsOwnFault = "the robot reports a fault";

/// The fault where a joint is too far from its commands.
inline constexpr const char* kDoesNotFollow = "the robot does not follow its commands";

/// Compares the robot's measurements with its commands.
class RobotMonitor {
 public:
  /// `period_us`: of the commands.
  RobotMonitor(const MotionLimits& limits, const MonitorOptions& options, int64_t period_us);

  /// Takes a measurement, or says why it is ignored. Another robot, or one that was restarted, is followed once ten
  /// measurements of it have come and none of the first; while `commanded`, only when those of the first are late.
  /// While `commanded`, a new run and a jump are faults.
  [[nodiscard]] MeasurementVerdict update(const Measurement& measurement, bool commanded);
  /// There was a measurement, which is not known: its age starts again.
  void heard() { age_us_ = 0; }
  /// One period has passed, in which this position was commanded.
  void commanded(const JointVector& position);
  /// Forgets all commands: the robot rests at `position`. The age of the measurement starts again.
  void rest_at(const JointVector& position);
  /// Forgets the fault.
  void reset() { fault_ = nullptr; }

  bool knows_robot() const { return newest_.has_value(); }
  const Measurement& newest() const { return *newest_; }
  int64_t run() const { return newest_ ? newest_->run : 0; }
  /// Time since the last measurement, by the ticks, microseconds.
  int64_t age_us() const { return age_us_; }
  bool late() const { return age_us_ > options_.state_timeout_us; }
  /// What is wrong with the robot, as text; null when nothing is.
  const char* fault() const;
  /// The joint that was furthest from its recent commands when the newest measurement came.
  int furthest_joint() const { return furthest_joint_; }
  /// Whether every joint is slower than a hundredth of its speed limit.
  bool stands() const;
  /// 1, and less where a joint is further from its recent commands than half of what is allowed.
  double speed_factor() const;

 private:
  static constexpr int kOthers = 10;
  static constexpr size_t kHistory = 100;  // commands, for the delay and the lag of the robot

  double tracking_error();

  MotionLimits limits_;
  MonitorOptions options_;
  int64_t period_us_;
  bool follows_other(int64_t run, bool commanded);
  double behind(const Measurement& measurement) const;

  std::optional<Measurement> newest_;
  int64_t other_run_ = 0;  // of the newest measurement of another robot
  int others_ = 0;         // how many of it have come since the newest of the one that is followed
  int64_t age_us_ = 0;
  const char* fault_ = nullptr;
  std::array<JointVector, kHistory> history_;
  size_t num_commands_ = 0;
  double error_ = 0;  // rad or m, of the newest measurement
  int furthest_joint_ = 0;
};

}  // namespace multireach::robot_bridge
