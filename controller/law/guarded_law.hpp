#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "controller/collision/body.hpp"
#include "controller/collision/proximity.hpp"
#include "controller/collision/rrt_planner.hpp"
#include "controller/ik/posture_search.hpp"
#include "controller/law/guarded_step.hpp"
#include "controller/law/reaching_law.hpp"
#include "controller/law/vite.hpp"
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

  const Chain& chain() const override { return chain_; }

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
  double clearance() { return proximity_.clearance(theta()); }
  /// Whether the arm is going around something.
  bool on_detour() const { return path_next_ < path_.size(); }

  /// One integration step. Without a target the arm brakes and stays.
  void step() override;

  /// How far the arm is measured to be from where this law has it (rad or m per joint), to be taken up at a bounded
  /// rate; zero for none. Ignored when not finite.
  void take_up(const JointVector& displacement) override;

  Eigen::Map<const Eigen::VectorXd> theta() const override { return map(state_.theta); }
  /// Per step; times steps_per_second it is rad/s (m/s).
  Eigen::Map<const Eigen::VectorXd> velocity() const override { return map(state_.velocity); }
  Eigen::Map<const Eigen::VectorXd> theta_target() const override { return map(state_.theta_target); }
  Eigen::Vector3d x() const override { return position(0); }
  /// K(theta_T): where the hand is going, the target itself when it is within reach.
  Eigen::Vector3d x_target() const override { return position(1); }
  JointVector weights() const override { return JointVector::Constant(chain_.size(), gamma()); }
  double gamma() const override { return state_.gamma; }
  double largest_gamma() const { return arm_.settings.gamma; }
  /// How far the hand at theta_T was from the target in the last step, m; 0 before the first.
  double residual_m() const override { return std::isfinite(state_.progress.residual) ? state_.progress.residual : 0; }
  bool out_of_reach() const override { return state_.progress.unreachable > 0; }
  /// How often theta_T was chosen by a search.
  int64_t posture_choices() const override { return posture_choices_; }
  /// How many linear systems were solved for the bounds, beyond one per step.
  int64_t bounded_solves() const { return bounded_solves_; }

 private:
  Eigen::Map<const Eigen::VectorXd> map(const std::array<double, kMaxJoints>& values) const {
    return {values.data(), chain_.size()};
  }
  Eigen::Vector3d position(int configuration) const {
    const std::array<double, 3> p = state_.position(configuration);
    return {p[0], p[1], p[2]};
  }
  void assign_target(const HandTarget& target);
  /// What every new goal begins with.
  void begin_reach(bool posture_only);
  void choose_posture();
  void set_theta_target(const JointVector& theta_target);
  /// |theta_T - theta|, added up joint by joint, so that many arms side by side get the same bits.
  double distance_to_go() const;
  void search_if_needed();
  void plan_around_obstruction();
  void follow_path();
  void end_path();
  /// A posture that meets the target and touches nothing, of some random ones: the nearest, or the first.
  std::optional<JointVector> clear_posture(uint64_t seed, bool nearest);

  Chain chain_;
  GuardedParameters parameters_;
  GuardedArm arm_;
  PostureSearch search_;
  PostureSolver solver_;
  Proximity proximity_;
  RrtPlanner planner_;
  GuardedState state_;
  std::optional<HandTarget> target_;
  HandTarget asked_;  // as it was given, where target_ was moved out of obstacles
  bool posture_only_ = false;
  Eigen::Vector3d chosen_for_ = Eigen::Vector3d::Zero();  // the target when theta_T was chosen
  Path path_;                                             // around an obstruction, to theta_T
  size_t path_next_ = 0;
  int obstructed_steps_ = 0, patience_ = 0;
  uint64_t plans_ = 0;
  int64_t posture_choices_ = 0, bounded_solves_ = 0;
};

}  // namespace multireach::controller
