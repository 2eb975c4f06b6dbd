#pragma once

#include "controller/task/task_target.hpp"
#include "kinematics/chain.hpp"
#include "kinematics/fast_chain.hpp"

namespace multireach::controller {

/// A rotation matrix whose third column is the tool's pointing axis.
Eigen::Matrix3d tool_frame(const Tool& tool);

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
  /// Moves `posture`, an IK solution of the target, along its self-motion towards `theta`.
  void approach(const TaskTarget& target, const JointVector& theta, JointVector& posture, double tolerance_m) const;
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
  double solve_task(const TaskTarget& target, JointVector& posture, double tolerance_m) const;
  template <int M>
  void approach_task(const TaskTarget& target, const JointVector& theta, JointVector& posture,
                     double tolerance_m) const;

  Chain chain_;
  Tool tool_;
  Eigen::Matrix3d tool_frame_;
  Arm arm_;
  JointVector lower_, upper_;  // infinite for locked joints
  JointVector weight_,
      mobile_;  // of each joint: weight, and 1 / weight; both 0 for a locked joint; empty when all are equal
};

}  // namespace multireach::controller
