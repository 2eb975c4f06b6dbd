#pragma once

#include <optional>
#include <string>
#include <utility>

#include "kinematics/joint_vector.hpp"
#include "robot_bridge/drivers/wire.hpp"

namespace multireach::drivers {

/// What the robot measures, in the order of the chain's joints.
struct Reading {
  JointVector position;  ///< rad or m
  JointVector velocity;  ///< rad/s or m/s
  JointVector effort;    ///< applied by the joint's drive, N m or N; zeros where the robot does not tell
};

struct DriverStatus {
  enum class Phase {
    kWaiting,  ///< for the connection, or for the user to enable the robot
    kReady,    ///< the robot is measured and obeys commands
    kFault,    ///< the robot has stopped; reset() may clear it
  };
  Phase phase = Phase::kWaiting;
  std::string text;  ///< what it waits for, or what is wrong and what the user can do about it
};

/// Messages of the robot's side that a driver did not use, since its start.
struct RefusedMessages {
  int64_t count = 0;
  std::string text{};  ///< how many, by cause; "" for none
};

/// Implements one robot's protocol: joint positions in, bytes out; bytes in, measured joint positions out. It only
/// encodes the commands that it gets: they come from the bridge and keep all limits. docs/your-robot.md tells how to
/// write one.
class Driver : public WireEnd {
 public:
  /// Joint positions (rad or m) and velocities for now. Called once for each JOINT_COMMAND, about 1000 times per second
  /// while the arm is commanded and the driver is ready; the driver may send fewer to a slower robot. `utime` is the
  /// nominal time of the command, microseconds, on an exact grid of the bridge.
  virtual void command(const JointVector& position, const JointVector& velocity, int64_t utime, const Time& now,
                       WireOutbox& out) = 0;
  /// The user enables the robot: power, brakes and torque may be switched on. Drivers of robots that are enabled
  /// otherwise ignore it.
  virtual void enable(const Time&, WireOutbox&) {}
  /// The user asks to leave a fault, where the robot allows it.
  virtual void reset(const Time&, WireOutbox&) {}

  /// What was measured since the last call, if anything. Only the newest reading counts.
  virtual std::optional<Reading> take_reading() = 0;
  virtual DriverStatus status() const = 0;
  virtual RefusedMessages refused() const { return {}; }
};

/// Picks those commands of the 1 kHz stream that a robot with a longer period gets: they are exactly one period apart
/// in the bridge's time, so that the delays of single messages do not change the robot's speed.
class RateDivider {
 public:
  explicit RateDivider(int64_t period_us) : period_us_(period_us) {}
  /// Whether the command of the nominal time `utime` is the first of its period.
  bool is_due(int64_t utime) {
    const int64_t slot = utime / period_us_;
    if (slot == slot_) return false;
    slot_ = slot;
    return true;
  }

 private:
  int64_t period_us_, slot_ = -1;
};

}  // namespace multireach::drivers
