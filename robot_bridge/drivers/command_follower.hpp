#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "robot_bridge/drivers/join_blend.hpp"
#include "robot_bridge/drivers/stop_ramp.hpp"

namespace multireach::drivers {

/// What a driver sends: the bridge's commands as they are; where one to three in a row are missing, their
/// extrapolation, then a deceleration; and from these, or from an arm that is elsewhere, a smooth transition to the
/// commands. Position and velocity are continuous, but where a position limit ends the motion. After `timeout_us`
/// without a command, the arm decelerates to standstill before it follows again. It is told the time, and when the
/// driver was stopped, so that the robot got nothing: the motion then begins again from rest, at the last position that
/// it got.
///
/// Every discontinuity gets a transition of its own, which ends at its time whatever comes after it: commands that
/// often miss their millisecond by a little still lead the arm to where they are.
class CommandFollower {
 public:
  CommandFollower(const robot_bridge::MotionLimits& limits, int64_t timeout_us)
      : limits_(limits), timeout_us_(timeout_us) {
    transitions_.reserve(kMostTransitions);
  }

  /// Whether commands are followed, or the arm decelerates after them.
  bool following() const { return sent_.has_value(); }
  /// Whether commands are refused until the arm is at standstill.
  bool stopping() const { return stopping_; }

  /// A command has arrived: `utime` is its nominal time, `arm` the measured position, which counts where none are
  /// followed. Requires !stopping(). Returns what to send for its time.
  const robot_bridge::MotionState& command(const JointVector& position, const JointVector& velocity, int64_t utime,
                                           const JointVector& arm, int64_t now_us);
  /// Call once in each millisecond: what to send where a command is missing; null otherwise. `utime` gets its nominal
  /// time.
  const robot_bridge::MotionState* missing(int64_t now_us, int64_t& utime);
  /// Decelerates to standstill, whatever commands come.
  void stop() { stopping_ = following(); }
  /// The robot has got nothing for some milliseconds: it is at rest at the last position that it got, or soon will be.
  void hold(int64_t now_us) {
    if (sent_) rest_at(JointVector(sent_->position), now_us);
  }
  /// Begins anew: nothing is known of the arm.
  void forget();

 private:
  /// What remains of a discontinuity of the commands.
  struct Transition {
    JoinBlend blend;
    double elapsed_s;
  };
  static constexpr size_t kMostTransitions = 32;

  void add_transitions(double ahead_s, robot_bridge::MotionState& state) const;
  void keep_positions_allowed(robot_bridge::MotionState& state) const;
  robot_bridge::MotionState extrapolated(int64_t elapsed_us) const;
  robot_bridge::MotionState between_commands(int64_t elapsed_us);
  void begin_transition(robot_bridge::MotionState& state);
  void rest_at(const JointVector& position, int64_t now_us);
  bool leaps(int64_t utime, int64_t now_us);

  robot_bridge::MotionLimits limits_;
  int64_t timeout_us_;
  std::optional<robot_bridge::MotionState> sent_;  // last, while commands are followed
  robot_bridge::MotionState last_;                 // sent last, where the arm is at rest
  robot_bridge::MotionState command_;              // the last, without transitions
  int64_t utime_ = 0, now_us_ = 0;                 // of the last command
  int64_t lead_us_ = 0;                            // of its time before the clock, ...
  int64_t lead_before_us_ = 0, lead_at_us_ = 0;    // ... and that of the last one of an earlier millisecond
  bool missed_ = false;                            // a command, since the last one
  std::optional<StopRamp> ramp_;
  bool stopping_ = false;
  std::vector<Transition> transitions_;
  JointVector lowest_, highest_;                     // positions allowed during transitions
  std::optional<robot_bridge::MotionState> joined_;  // what the last transition began with, in the same millisecond
  int64_t joined_us_ = 0;
};

}  // namespace multireach::drivers
