#pragma once

#include "controller/law/path_follower.hpp"
#include "controller/path/path_planner.hpp"

namespace multireach::controller {

/// The short way of a reach under the guarded law. While the law already moves the arm, it plans a path from the state
/// that the arm will have delay() steps after the target was set, and rehearses the law's own reach from there. Then,
/// if the planned hand path is the shorter one, it leads the arm along it: the velocity of the joints' attractor
/// follows the path (through the state's disturbance term) and gamma is 0. All bounds of the law hold as always. A path
/// is given up, and the law continues alone, when the target moves, when the arm is disturbed or left behind, and at
/// its end. Deterministic; allocates all memory at construction.
class ReachPath {
 public:
  /// `work`: of PathPlanner, for each plan.
  ReachPath(const Chain& chain, const GuardedSettings& settings, const LevenbergMarquardtIk& solver, int work);

  /// Steps from the target to the beginning of the path: 0.05 s.
  int delay() const { return delay_; }

  /// Begins to plan, for the arm in `state` and its new position target, whose theta_T has been set.
  void begin(const GuardedArm& arm, const GuardedState& state, const TaskTarget& target);
  /// Gives up the plan and the path.
  void stop();

  /// Call it before each step of the law. Plans; where it leads the arm, writes theta_T, gamma and the disturbance of
  /// `state`.
  void before_step(const GuardedArm& arm, const TaskTarget& target, Proximity& proximity, GuardedState& state);
  /// Call it after each step. Returns true when the path has ended: the law must restart its schedule.
  bool after_step(GuardedState& state);
  /// Whether it leads the arm.
  bool leads() const { return leads_; }

 private:
  void rehearse(const GuardedArm& arm, int steps);
  bool target_moved(const GuardedArm& arm, const TaskTarget& target) const;
  bool take_over(const GuardedArm& arm, GuardedState& state);

  PathPlanner planner_;
  PathFollower follower_;
  int work_, delay_;
  int until_path_ = 0;                // steps until the path begins; 0 when no plan is under way
  bool leads_ = false, led_ = false;  // led_: in this step
  TaskTarget target_;                 // the target of the plan
  // The rehearsal of the law's own reach.
  GuardedState rehearsed_;
  std::array<double, 3> rehearsed_position_{};
  double rehearsed_length_ = 0;
  bool rehearsal_arrived_ = false;
};

}  // namespace multireach::controller
