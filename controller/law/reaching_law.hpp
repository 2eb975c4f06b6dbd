#pragma once

#include <cstdint>
#include <span>

#include "controller/collision/obstacle.hpp"
#include "controller/task/hand_target.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

/// What became of a target.
enum class Aimed {
  kWithinReach,  ///< a posture inside the limits reaches it
  kOutOfReach,   ///< none was found; what the arm does then is the law's affair
  kRefused,      ///< not finite, or the direction or orientation is none; nothing has changed
};

/// A control law with the arm that it moves: a target in, joint angles out, one integration step at a time. Vectors
/// have one element per joint; velocities are per step.
class ReachingLaw {
 public:
  virtual ~ReachingLaw() = default;
  virtual const Chain& chain() const = 0;

  /// Puts the arm at rest at `theta`. Returns false, and changes nothing, when it cannot be a posture of the arm: of
  /// another size, not finite, or beyond 1e5 rad. It may be outside the limits.
  virtual bool start(const JointVector& theta) = 0;
  /// Takes a new target and chooses the target posture for it.
  virtual Aimed aim(const HandTarget& target) = 0;
  /// Takes a target that has moved a little; the target posture follows it by itself.
  virtual Aimed follow(const HandTarget& target) = 0;
  /// Goes to a posture instead of a hand target. Returns false for one outside the limits.
  virtual bool aim_at_posture(const JointVector& theta) = 0;
  /// One integration step; without a target none.
  virtual void step() = 0;
  /// How far the arm is measured to be from where the law has it (rad or m per joint), to be taken up at a bounded
  /// rate; zero for none.
  virtual void take_up(const JointVector& displacement) = 0;
  /// Replaces all obstacles. Returns how many were refused.
  virtual int set_obstacles(std::span<const Obstacle> obstacles) = 0;

  virtual Eigen::Map<const Eigen::VectorXd> theta() const = 0;
  virtual Eigen::Map<const Eigen::VectorXd> velocity() const = 0;
  virtual Eigen::Map<const Eigen::VectorXd> theta_target() const = 0;
  virtual Eigen::Vector3d x() const = 0;         ///< K(theta), m, in W
  virtual Eigen::Vector3d x_target() const = 0;  ///< where the hand is going, m, in W
  virtual JointVector weights() const = 0;       ///< w_x / w_theta of each joint, rad^2/m^2
  virtual double gamma() const = 0;              ///< rad^2/m^2
  virtual double residual_m() const = 0;         ///< |target - K(theta_T)|
  virtual bool out_of_reach() const = 0;
  virtual int64_t posture_choices() const = 0;  ///< how often theta_T was chosen by a search
};

}  // namespace multireach::controller
