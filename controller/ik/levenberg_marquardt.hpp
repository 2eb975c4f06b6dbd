#pragma once

#include <limits>

#include "controller/task/task_target.hpp"
#include "kinematics/chain.hpp"
#include "kinematics/fast_chain.hpp"

namespace multireach::controller {

/// A rotation matrix whose third column is the tool's pointing axis.
Eigen::Matrix3d tool_frame(const Tool& tool);

/// A descent of LevenbergMarquardtIk to a local minimum of the task error, interrupted between two steps.
struct IkDescent {
  JointVector posture;  ///< inside the limits
  double error =
      std::numeric_limits<double>::infinity();  ///< the task error at `posture`, m; infinite before the start
  double damping = 1e-4;  ///< m^2, against singular values of some 0.1 m; adapted as Levenberg and Marquardt do
  int steps = 0;          ///< taken so far
  bool finished = false;
};

/// A movement of an IK solution along its self-motion, interrupted between two steps.
struct IkApproach {
  JointVector posture;                                         ///< an IK solution, the nearest found so far
  double distance2 = std::numeric_limits<double>::infinity();  ///< its squared, weighted distance
  double stride = 1;                                           ///< the share of the way that the next candidate tries
  int strides = 0;                                             ///< candidates so far
  IkDescent candidate{};  ///< back to the target, from a stride along the self-motion
  bool descends = false, finished = false;
};

/// Iterative inverse kinematics inside the joint limits, from a given start: damped Newton steps (Levenberg-Marquardt)
/// that exclude joints blocked by their limits.
class LevenbergMarquardtIk {
 public:
  /// `weights`: of the joints (controller/task/joint_weights.hpp); empty when all are equal. Locked joints keep their
  /// values, also outside the limits.
  LevenbergMarquardtIk(const Chain& chain, const Tool& tool, const JointVector& weights = {});

  /// The configuration with every joint that is not locked clamped to its limits.
  JointVector clamped(const JointVector& posture) const { return posture.cwiseMax(lower_).cwiseMin(upper_); }
  /// |to - from|, each joint times its weight. Locked joints do not count.
  double distance(const JointVector& from, const JointVector& to) const;

  /// Moves `posture` (inside the limits) to a nearby local minimum of the task error and returns the error there, m.
  /// Stops when the error is at most `tolerance_m`.
  double solve(const TaskTarget& target, JointVector& posture, double tolerance_m) const;
  /// Continues a descent for at most `most` steps, or until it is finished: the same steps as those of solve(). Returns
  /// its work: the number of times that the kinematics were computed, at most `most` + 1.
  int descend(const TaskTarget& target, IkDescent& descent, double tolerance_m, int most) const;
  /// Continues to move an IK solution of the target along its self-motion towards `theta`, until `most` work is done or
  /// the approach is finished. Returns its work, which may exceed `most` by 2.
  int approach(const TaskTarget& target, const JointVector& theta, IkApproach& run, double tolerance_m, int most) const;
  /// The task error at `posture`: distance and weighted rotation, m.
  double error(const TaskTarget& target, const JointVector& posture) const;

 private:
  using Arm = FastChain<0, double>;
  template <int M>
  struct Task {
    Eigen::Matrix<double, M, Eigen::Dynamic, 0, M, kMaxJoints> jacobian;
    Eigen::Matrix<double, M, 1> error;
  };
  template <int M>
  void task(const TaskTarget& target, const JointVector& posture, Task<M>& task) const;
  template <int M>
  JointVector damped_step(const JointVector& posture, const Task<M>& task, const Eigen::Matrix<double, M, 1>& error,
                          double damping) const;
  template <int M>
  int descend_task(const TaskTarget& target, IkDescent& descent, double tolerance_m, int most) const;
  template <int M>
  int approach_task(const TaskTarget& target, const JointVector& theta, IkApproach& run, double tolerance_m,
                    int most) const;

  Chain chain_;
  Tool tool_;
  Eigen::Matrix3d tool_frame_;
  Arm arm_;
  JointVector lower_, upper_;  // infinite for locked joints
  JointVector weight_,
      mobile_;  // of each joint: weight, and 1 / weight; both 0 for a locked joint; empty when all are equal
};

}  // namespace multireach::controller
