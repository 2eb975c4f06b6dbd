#pragma once

#include <string>

#include "kinematics/chain.hpp"
#include "robot_bridge/drivers/wire.hpp"

namespace multireach::drivers {

/// Replaces a robot's controller: answers by its protocol as the real one does, with its rates, time-outs, limits and
/// faults.
class Emulator : public WireEnd {
 public:
  /// Something hit the arm.
  virtual void collide() = 0;
  /// What a person does at the robot: restarts it where it has ended, confirms what must be confirmed there.
  virtual void restart() = 0;
  /// Measured joint positions, rad or m.
  virtual const JointVector& position() const = 0;
  /// What the robot does: "", or why it has stopped, as its own log would tell.
  virtual const std::string& fault() const = 0;
};

/// Joints that follow their command as a critically damped spring.
struct EmulatedJoints {
  JointVector position, velocity;  ///< rad, rad/s (m, m/s)

  explicit EmulatedJoints(const JointVector& start) : position(start), velocity(JointVector::Zero(start.size())) {}
  void follow(const JointVector& target, double natural_frequency_rad_s, double period_s) {
    const double w = natural_frequency_rad_s;
    velocity += period_s * (w * w * (target - position) - 2 * w * velocity);
    position += period_s * velocity;
  }
  void stop() { velocity.setZero(); }
};

}  // namespace multireach::drivers
