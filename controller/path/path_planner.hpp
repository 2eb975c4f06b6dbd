#pragma once

#include "controller/collision/proximity.hpp"
#include "controller/ik/levenberg_marquardt.hpp"
#include "controller/path/path_optimizer.hpp"
#include "numeric/random.hpp"

namespace multireach::controller {

/// Plans a joint path to a position target whose hand path is short: optimises several first guesses (PathOptimizer)
/// and keeps the best. The first guess is the straight line in joint space to theta_T; if the result is far from
/// straight, lines over other postures and to other IK solutions follow. Works in slices: advance() does a counted
/// amount of work. Deterministic; allocates all memory at construction.
class PathPlanner {
 public:
  /// `mobility`: 1 / weight^2 of each joint; 0 for a locked one. `solver`: the iterative inverse kinematics of the same
  /// chain.
  PathPlanner(const Chain& chain, const std::array<double, kMaxJoints>& mobility, const LevenbergMarquardtIk& solver);

  /// Begins a plan from `start` to `target` (m, in W). `theta_target` is an IK solution of the target.
  void begin(const JointVector& start, const Eigen::Vector3d& target, const JointVector& theta_target);
  /// Works on the plan. The unit of `work` is one step of PathOptimizer, 5 us with 4 joints and 11 us with 7. Paths
  /// whose knots are nearer to an obstacle than the margin are rejected, if `proximity` has something to avoid.
  void advance(int work, Proximity& proximity);

  /// Whether there is a path; path() and length_m() are of the best so far.
  bool found() const { return found_; }
  const JointPath& path() const { return best_; }
  /// Length of the hand's path along the lines in joint space between the knots, m.
  double length_m() const { return best_length_; }

 private:
  enum class Stage { kGuess, kOptimize, kMeasure, kCheckClearance, kFinished };

  int work_once(Proximity& proximity);
  /// Writes the next first guess to candidate_. Returns false when there is none.
  bool guess();
  /// Moves the end of the candidate onto the target, and measures the candidate. Whether it is better than the best.
  bool measure();
  /// The pass over the candidate is over.
  void end_pass();

  Chain chain_;
  LevenbergMarquardtIk solver_;
  PathOptimizer optimizer_;
  FastLinks<0, double> links_;
  double reach_;
  std::array<double, kMaxJoints> mobility_;
  JointVector start_, theta_target_;
  Eigen::Vector3d target_ = Eigen::Vector3d::Zero();
  double distance_ = 0;
  Stage stage_ = Stage::kFinished;
  int guesses_ = 0, pass_ = 0, steps_ = 0, owed_ = 0;
  size_t checked_ = 0;
  JointPath candidate_, best_;
  double candidate_length_ = 0, best_length_ = 0;
  bool found_ = false;
};

}  // namespace multireach::controller
