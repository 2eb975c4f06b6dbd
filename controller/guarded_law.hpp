#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "controller/body.hpp"
#include "controller/posture_search_options.hpp"
#include "controller/reaching_law.hpp"
#include "controller/vite.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

/// The law `guarded`: the two attractors of the paper and its coherence objective (6), kept inside the joints' limits,
/// never trapped, at ease with every target. docs/guarantees.md says what it promises and why.
struct GuardedParameters {
  ViteGains gains{0.08, 0.02};  ///< per step; alpha (1 - beta)^2 >= 4 beta (1 - alpha), so that no attractor overshoots
  std::optional<double> gamma{};  ///< rad^2/m^2, the weight of the hand's attractor; default 8.5 / reach^2
  double steps_per_second = 140;  ///< integration steps, to turn the limits' seconds into steps
  JointVector acceleration{};     ///< rad/s^2 (m/s^2), the largest of each joint; empty for no limit
  Tool tool{};
  Body body{};  ///< without a link radius, obstacles and self-collision are not looked at
  PostureSearchOptions posture_search{};
};

/// One arm under the guarded law: a target in, joint angles out, step by step. Nothing is allocated and no lock is
/// taken after construction. Not for use from several threads at once; copies are independent.
class GuardedLaw final : public ReachingLaw {
 public:
  /// Throws std::invalid_argument for parameters that make no sense (gains that overshoot; gamma, steps per second or
  /// an acceleration that is not positive; a tool axis that is no unit vector).
  explicit GuardedLaw(const Chain& chain, const GuardedParameters& parameters = {});
  GuardedLaw(const GuardedLaw& other);
  GuardedLaw& operator=(const GuardedLaw& other);
  GuardedLaw(GuardedLaw&&) noexcept;
  GuardedLaw& operator=(GuardedLaw&&) noexcept;
  ~GuardedLaw() override;

  const Chain& chain() const override;

  /// Puts the arm at rest at `theta`, which may be outside the limits: it then comes back. Returns false, and changes
  /// nothing, when the posture has not size() elements, is not finite, or is beyond 1e5 rad.
  bool start(const JointVector& theta) override;

  /// Takes a new target and chooses the target posture nearest to the arm's. May take as long as a search takes:
  /// some 0.05 ms with a closed form, some milliseconds without.
  Aimed aim(const HandTarget& target) override;
  /// Takes a target that has moved a little; the target posture follows it by itself.
  Aimed follow(const HandTarget& target) override;
  /// Goes to a posture (inside the limits) instead of a hand target. Returns false for one that is not.
  bool aim_at_posture(const JointVector& theta) override;
  /// The same without a search: from a target posture that the caller has chosen, which should meet the target; where
  /// it does not, theta_T goes on from there, and a search follows only when it gets stuck.
  Aimed aim(const HandTarget& target, const JointVector& theta_target);

  /// Replaces all obstacles (which need a body). Returns how many were refused.
  int set_obstacles(std::span<const Obstacle> obstacles) override;
  /// The smallest distance to anything, less the margin, m; the body's sight when nothing is nearer.
  double clearance();
  /// Whether the arm is going around something.
  bool on_detour() const;

  /// One integration step. Without a target the arm brakes and stays.
  void step() override;

  /// How far the arm is measured to be from where this law has it (rad or m per joint), to be taken up at a bounded
  /// rate; zero for none. Ignored when not finite.
  void take_up(const JointVector& displacement) override;

  Eigen::Map<const Eigen::VectorXd> theta() const override;
  /// Per step; times steps_per_second it is rad/s (m/s).
  Eigen::Map<const Eigen::VectorXd> velocity() const override;
  Eigen::Map<const Eigen::VectorXd> theta_target() const override;
  Eigen::Vector3d x() const override;
  /// K(theta_T): where the hand is going, the target itself when it is within reach.
  Eigen::Vector3d x_target() const override;
  JointVector weights() const override;
  double gamma() const override;
  double largest_gamma() const;
  /// How far the hand at theta_T is from the target, m.
  double residual_m() const override;
  bool out_of_reach() const override;
  /// How often theta_T was chosen by a search.
  int64_t posture_choices() const override;
  /// How many linear systems were solved for the bounds, beyond one per step.
  int64_t bounded_solves() const;

 private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace multireach::controller
