#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "controller/collision/body.hpp"
#include "controller/collision/proximity.hpp"
#include "controller/collision/rrt_planner.hpp"
#include "controller/ik/multi_start.hpp"
#include "controller/law/guarded_step.hpp"
#include "controller/law/reach_path.hpp"
#include "controller/law/reaching_law.hpp"
#include "controller/law/vite.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

/// Parameters of the law `guarded`: the two attractors of the paper and its coherence objective (6), inside the joint
/// limits, without spurious attractors, for unreachable, moving and singular targets. docs/guarantees.md states its
/// guarantees and why they hold.
struct GuardedParameters {
  /// Gains of both attractors per step of 1/140 s, whatever steps_per_second is: 5.72 rad/s with damping ratio 1.02. No
  /// attractor may overshoot: alpha (1 - beta)^2 >= 4 beta (1 - alpha).
  ViteGains gains{0.08, 0.02};
  /// Instead of `gains`: natural frequency, at most kMaxNaturalFrequency, and damping ratio, 1 to kMaxDampingRatio.
  std::optional<AttractorMotion> attractor{};
  static constexpr double kMaxNaturalFrequency = 1000, kMaxDampingRatio = 100;
  std::optional<double> gamma{};  ///< rad^2/m^2, the weight of the hand's attractor; default 8.5 / reach^2
  /// Integration steps per second. The motion is the same at any rate, up to half a step in time.
  double steps_per_second = kReferenceRate;
  /// rad/s^2 (m/s^2), acceleration limit of each joint; infinite for none. Empty: those of default_acceleration(),
  /// which let a joint reach its speed limit in 0.1 s.
  JointVector acceleration{};
  /// Weight of each joint; infinite locks it. Empty: those of default_joint_weights(). Only their ratios matter.
  JointVector joint_weights{};
  /// s: a target moves with the velocity that it was set with for at most this long after it was set or updated last;
  /// then it stands still.
  double extrapolation_s = 1;
  /// Work spent on the plan of a short hand path at each new position target, in optimisation steps (5 us with 4
  /// joints, 11 us with 7), spread over the first 0.05 s; 0: no plan, the attractors alone lead the arm.
  int path_work = 0;
  static constexpr int kUsualPathWork = 70;  ///< with less, ways become longer
  Tool tool{};
  Body body{};  ///< without a link radius, obstacles and self-collision are ignored
  IkOptions ik{};
};

/// A search for a collision-free IK solution, interrupted between two steps.
struct CollisionFreeSearch {
  TaskTarget target;
  JointVector theta;  ///< the solution is to be near to it, if `nearest`
  uint64_t seed = 0;
  bool nearest = false;  ///< the nearest solution; otherwise the first
  uint64_t counter = 0;  ///< random numbers drawn
  int tries = 0;         ///< random starts ended
  bool descends = false, finished = false;
  IkDescent descent{};
  std::optional<JointVector> best{};
};

/// The guarded law for one arm: takes a target and computes joint positions, one integration step at a time. After
/// construction it allocates no memory and takes no lock. Not thread-safe; copies are independent.
class GuardedLaw final : public ReachingLaw {
 public:
  /// Throws std::invalid_argument for invalid parameters: gains that overshoot, gamma outside [0, 1e12], steps per
  /// second, an extrapolation or an acceleration that is not positive, a tool axis that is not a unit vector.
  explicit GuardedLaw(const Chain& chain, const GuardedParameters& parameters = {});

  const Chain& chain() const override { return chain_; }

  /// Puts the arm at rest at `theta`. Outside the limits is allowed: the arm then returns. Returns false, and changes
  /// nothing, when `theta` does not have size() elements, is not finite, or is beyond 1e5 rad.
  bool start(const JointVector& theta) override;

  /// Sets a new target and searches theta_T, the IK solution nearest to the arm. The search takes some 0.05 ms with a
  /// closed form, some milliseconds without. For a position target, the next steps also plan a short hand path to it
  /// (GuardedParameters::path_work).
  TargetResult set_target(const TaskTarget& target) override;
  /// Updates a target that has moved a little; theta_T follows without a search. A target with a velocity must be
  /// updated within GuardedParameters::extrapolation_s, or it stops.
  TargetResult update_target(const TaskTarget& target) override;
  /// Goes to a joint configuration instead of a hand target; locked joints stay. Returns false when it is outside the
  /// limits, and before start().
  bool set_joint_target(const JointVector& theta) override;
  /// Sets a new target without a search. `theta_target` should be an IK solution of it. If it is not, theta_T moves
  /// from there towards a solution; a search follows only when theta_T gets stuck. No path is planned.
  TargetResult set_target(const TaskTarget& target, const JointVector& theta_target);

  /// Takes over the motion of a law for the same arm, to simulate how it goes on: its state, target and search for
  /// theta_T, but not its obstacles, its body and a planned path. Allocates nothing.
  void take_motion(const GuardedLaw& other);

  /// Replaces all obstacles. Returns how many were refused; all of them without a body.
  int set_obstacles(std::span<const Obstacle> obstacles) override;
  /// The smallest distance to an obstacle or between links, minus the margin, m; at most the body's query_distance_m.
  double clearance() { return proximity_.clearance(theta()); }
  /// Whether the arm follows a planned path around an obstruction.
  bool following_path() const { return path_next_ < path_.size(); }
  /// Whether the arm follows a path that was planned because its hand path is short. gamma() is 0 meanwhile.
  bool following_short_path() const { return reach_path_ && reach_path_->leads(); }

  /// One integration step. Without a target the arm brakes and stops. A search for another theta_T, and a plan around
  /// an obstruction, are continued by a bounded part in each step; the result is taken over when it is complete.
  void step() override;

  /// Sets the measured displacement of the arm from theta() (rad or m per joint); zero for none. theta() follows it at
  /// a bounded rate. Ignored when not finite.
  void compensate(const JointVector& displacement) override;

  Eigen::Map<const Eigen::VectorXd> theta() const override { return map(state_.theta); }
  /// Per step; multiply by steps_per_second for rad/s (m/s).
  Eigen::Map<const Eigen::VectorXd> velocity() const override { return map(state_.velocity); }
  Eigen::Map<const Eigen::VectorXd> theta_target() const override { return map(state_.theta_target); }
  Eigen::Vector3d x() const override { return position(0); }
  /// K(theta_T): the position to which the hand goes; the target itself when it is within reach.
  Eigen::Vector3d x_target() const override { return position(1); }
  JointVector weights() const override { return JointVector::Constant(chain_.size(), gamma()); }
  double gamma() const override { return state_.gamma; }
  double largest_gamma() const { return arm_.settings.gamma; }
  /// The task error of theta_T in the last step, m; 0 before the first.
  double residual_m() const override { return std::isfinite(state_.progress.residual) ? state_.progress.residual : 0; }
  bool unreachable() const override { return state_.progress.unreachable > 0; }
  Obstruction obstruction() const override;
  /// Whether another theta_T is being searched.
  bool searching() const { return searching_; }
  /// Whether a path around an obstruction is being planned, which takes several steps.
  bool planning() const { return planning_.has_value(); }
  /// Number of IK searches for theta_T.
  int64_t ik_searches() const override { return ik_searches_; }
  /// Number of linear systems solved for the bounds, beyond one per step.
  int64_t bounded_solves() const { return bounded_solves_; }

 private:
  Eigen::Map<const Eigen::VectorXd> map(const std::array<double, kMaxJoints>& values) const {
    return {values.data(), chain_.size()};
  }
  Eigen::Vector3d position(int configuration) const {
    const std::array<double, 3> p = state_.position(configuration);
    return {p[0], p[1], p[2]};
  }
  void assign_target(const TaskTarget& target);
  /// Resets the state of the reach, for a new goal.
  void begin_reach(bool posture_only);
  void begin_search();
  /// Continues the search for theta_T by about `work` units (MultiStartIk::continue_search()). When it is complete,
  /// takes its result over and returns true.
  bool continue_search(int work);
  void set_theta_target(const JointVector& theta_target);
  /// `posture` with the locked joints where they are.
  JointVector with_locked_joints(JointVector posture) const;
  /// |theta_T - theta|, summed joint by joint in order, so that batches give bit-identical results.
  double distance_to_go() const;
  void search_if_needed();
  /// Begins, or continues by a bounded part, a plan around an obstruction that has stopped the arm for long enough.
  void plan_around_obstruction();
  void begin_plan();
  bool plan_is_outdated() const;
  void begin_path();
  void follow_path();
  void end_path();
  /// Begins a search for a collision-free IK solution of `target`, from random starts: the nearest to theta(), or the
  /// first found.
  CollisionFreeSearch collision_free_search(const TaskTarget& target, uint64_t seed, bool nearest) const;
  /// Continues it by about `work` units; returns true when it is finished.
  bool continue_search(CollisionFreeSearch& search, int work);
  /// Lets theta_T move again, after a path whose end it was.
  void release_theta_target(const JointVector& theta_target);

  Chain chain_;
  GuardedParameters parameters_;
  GuardedArm arm_;
  MultiStartIk search_;
  LevenbergMarquardtIk solver_;
  Proximity proximity_;
  RrtPlanner planner_;
  std::optional<ReachPath> reach_path_;
  GuardedState state_;
  std::optional<TaskTarget> target_;
  TaskTarget requested_target_;  // the target as given; target_ is moved out of obstacles
  bool started_ = false, posture_only_ = false;
  bool searching_ = false;  // for theta_T: by search_ without regard to obstacles; then, if necessary, collision-free
  IkSearch ik_search_;
  std::optional<CollisionFreeSearch> collision_free_search_;
  int64_t steps_since_update_ = 0;
  Eigen::Vector3d searched_target_ = Eigen::Vector3d::Zero();  // target position when theta_T was chosen
  /// State of a plan around an obstruction: the IK search for another goal, if any, then the planner's work.
  struct Planning {
    JointVector start, goal;
    Eigen::Vector3d target;  // for which it is
    double to_go_m;          // the hand's distance from it at the start
    int free_steps = 0;      // since the arm was last obstructed
    std::optional<CollisionFreeSearch> other_goal{};
    bool has_begun = false;  // the planner
  };
  std::optional<Planning> planning_;
  Path path_;  // planned around an obstruction
  size_t path_next_ = 0;
  int obstructed_steps_ = 0, steps_until_plan_ = 0;
  uint64_t plans_ = 0;
  int64_t ik_searches_ = 0, bounded_solves_ = 0;
};

}  // namespace multireach::controller
