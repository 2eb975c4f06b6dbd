#pragma once

#include "controller/task/hand_target.hpp"
#include "kinematics/chain.hpp"
#include "kinematics/fast_chain.hpp"

namespace multireach::controller {

/// A rotation whose third column is the tool's axis.
Eigen::Matrix3d tool_frame(const Tool& tool);

/// Finds a posture inside the limits for a hand target, from a given one: damped Newton steps (Levenberg-Marquardt)
/// that leave out the joints whose limits stand in the way.
class PostureSolver {
 public:
  PostureSolver(const Chain& chain, const Tool& tool);

  /// Moves `posture` (inside the limits) to the nearest minimum of the hand's error and returns the error there, m;
  /// stops at `tolerance_m`.
  double solve(const HandTarget& target, JointVector& posture, double tolerance_m) const;
  /// Moves `posture`, which meets the target, along the postures that do so towards `theta`.
  void approach(const HandTarget& target, const JointVector& theta, JointVector& posture, double tolerance_m) const;
  /// The hand's error at `posture`: distance and weighted rotation, m.
  double error(const HandTarget& target, const JointVector& posture) const;

 private:
  using Arm = FastChain<0, double>;
  template <int M>
  struct Task {
    Eigen::Matrix<double, M, Eigen::Dynamic, 0, M, kMaxJoints> jacobian;
    Eigen::Matrix<double, M, 1> error;
  };
  template <int M>
  void task(const HandTarget& target, const JointVector& posture, Task<M>& task) const;
  template <int M>
  JointVector damped_step(const JointVector& posture, const Task<M>& task, const Eigen::Matrix<double, M, 1>& error,
                          double damping) const;
  template <int M>
  double solve_task(const HandTarget& target, JointVector& posture, double tolerance_m) const;
  template <int M>
  void approach_task(const HandTarget& target, const JointVector& theta, JointVector& posture,
                     double tolerance_m) const;

  Chain chain_;
  Tool tool_;
  Eigen::Matrix3d tool_frame_;
  Arm arm_;
};

}  // namespace multireach::controller
