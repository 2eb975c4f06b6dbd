#pragma once

#include <cstdint>
#include <span>

#include "controller/collision/obstacle.hpp"
#include "controller/task/task_target.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

/// Whether a target was accepted and is reachable.
enum class TargetResult {
  kReachable,    ///< an IK solution inside the limits exists
  kUnreachable,  ///< no IK solution was found; the reaction of the arm depends on the law
  kRefused,      ///< not finite, or an invalid direction or orientation: target_fault() says why; nothing has changed
  kNotStarted,   ///< start() has not been called: the law does not know where the arm is; nothing has changed
};

/// What keeps the hand from its target.
enum class Obstruction {
  kNone,      ///< nothing that is known
  kTarget,    ///< the target is inside an obstacle, or too near to it for the end effector
  kObstacle,  ///< an obstacle, or the arm's own links, in the way
};

/// Interface of a control law, with the state of the arm that it moves: takes a target and computes joint positions,
/// one integration step at a time. Vectors have one element per joint; velocities are per step.
class ReachingLaw {
 public:
  virtual ~ReachingLaw() = default;
  virtual const Chain& chain() const = 0;

  /// Puts the arm at rest at `theta`, which may be outside the limits. Returns false, and changes nothing, when `theta`
  /// has another size, is not finite, or is beyond 1e5 rad.
  virtual bool start(const JointVector& theta) = 0;
  /// Sets a new target and searches theta_T, an IK solution of it. Call start() first.
  virtual TargetResult set_target(const TaskTarget& target) = 0;
  /// Updates a target that has moved a little; theta_T follows without a search.
  virtual TargetResult update_target(const TaskTarget& target) = 0;
  /// Goes to a joint configuration instead of a hand target. Returns false when it is outside the limits, and before
  /// start().
  virtual bool set_joint_target(const JointVector& theta) = 0;
  /// One integration step. Without a target the arm brakes, or does not move; before start() nothing happens.
  virtual void step() = 0;
  /// Sets the measured displacement of the arm from theta() (rad or m per joint), to be compensated at a bounded rate;
  /// zero for none.
  virtual void compensate(const JointVector& displacement) = 0;
  /// Replaces all obstacles. Returns how many were refused.
  virtual int set_obstacles(std::span<const Obstacle> obstacles) = 0;

  virtual Eigen::Map<const Eigen::VectorXd> theta() const = 0;
  virtual Eigen::Map<const Eigen::VectorXd> velocity() const = 0;
  virtual Eigen::Map<const Eigen::VectorXd> theta_target() const = 0;
  virtual Eigen::Vector3d x() const = 0;         ///< K(theta), m, in W
  virtual Eigen::Vector3d x_target() const = 0;  ///< position to which the hand goes, m, in W
  virtual JointVector weights() const = 0;       ///< w_x / w_theta of each joint, rad^2/m^2
  virtual double gamma() const = 0;              ///< rad^2/m^2
  virtual double residual_m() const = 0;         ///< |target - K(theta_T)|
  virtual bool unreachable() const = 0;
  virtual Obstruction obstruction() const { return Obstruction::kNone; }
  virtual int64_t ik_searches() const = 0;  ///< number of IK searches for theta_T
};

}  // namespace multireach::controller
