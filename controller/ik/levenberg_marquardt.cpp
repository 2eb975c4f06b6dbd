#include "controller/ik/levenberg_marquardt.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "controller/task/task_rows.hpp"
#include "numeric/cholesky.hpp"
#include "numeric/interval.hpp"
#include "numeric/trigonometry.hpp"

namespace multireach::controller {
Eigen::Matrix3d tool_frame(const Tool& tool) {
  return rotation_from_z(tool.axis);
}

LevenbergMarquardtIk::LevenbergMarquardtIk(const Chain& chain, const Tool& tool, const JointVector& weights)
    : chain_(chain),
      tool_(tool),
      tool_frame_(tool_frame(tool)),
      arm_(chain, tool_frame_),
      lower_(chain.lower()),
      upper_(chain.upper()) {
  if (weights.size() == 0 || (weights.array() == weights[0]).all()) return;
  weight_ = weights;
  mobile_ = weights.cwiseInverse();
  for (int i = 0; i < chain.size(); ++i) {
    if (std::isfinite(weights[i])) continue;
    weight_[i] = mobile_[i] = 0;
    lower_[i] = -std::numeric_limits<double>::infinity();
    upper_[i] = std::numeric_limits<double>::infinity();
  }
}

double LevenbergMarquardtIk::distance(const JointVector& from, const JointVector& to) const {
  return weight_.size() == 0 ? (to - from).norm() : (to - from).cwiseProduct(weight_).norm();
}

template <int M>
void LevenbergMarquardtIk::task(const TaskTarget& target, const JointVector& posture, Task<M>& task) const {
  const int n = chain_.size();
  Arm::PerJoint theta{};
  for (int i = 0; i < n; ++i) theta[i] = posture[i];
  Arm::Hand hand;
  arm_.forward_kinematics<(M > 3)>(theta, hand);
  task.jacobian.resize(M, n);
  for (int k = 0; k < 3; ++k) {
    task.error[k] = target.position[k] - hand.position[k];
    for (int i = 0; i < n; ++i) task.jacobian(k, i) = hand.jacobian[k][i];
  }
  if constexpr (M > 3) {
    const double length = tool_.orientation_length_m;
    const auto turn = orientation_error<M>(hand.rotation, goal_axes(target, tool_frame_), length);
    for (int r = 0; r < M - 3; ++r) {
      task.error[3 + r] = turn[r];
      for (int i = 0; i < n; ++i) task.jacobian(3 + r, i) = orientation_row<M>(hand, r, i, length);
    }
  }
}

template <int M>
JointVector LevenbergMarquardtIk::damped_step(const JointVector& posture, const Task<M>& task,
                                              const Eigen::Matrix<double, M, 1>& error, double damping) const {
  auto jacobian = task.jacobian;
  const bool weighs = weight_.size() > 0;
  if (weighs) jacobian = jacobian * mobile_.asDiagonal();
  JointVector step = JointVector::Zero(chain_.size());
  for (int round = 0; round < chain_.size(); ++round) {
    Eigen::Matrix<double, M, M> A = jacobian.lazyProduct(jacobian.transpose());
    A.diagonal().array() += damping;
    step = jacobian.transpose().lazyProduct(cholesky_solve<M>(A, error));
    bool blocked = false;
    for (int i = 0; i < chain_.size(); ++i) {
      if (!leads_out(posture[i], lower_[i], upper_[i], step[i])) continue;
      jacobian.col(i).setZero();
      blocked = true;
    }
    if (!blocked) break;
  }
  if (weighs) step = step.cwiseProduct(mobile_);
  return step;
}

template <int M>
double LevenbergMarquardtIk::solve_task(const TaskTarget& target, JointVector& posture, double tolerance_m) const {
  constexpr int kMaxSteps = 60;
  constexpr double kMaxStep = 0.5;    // rad (or m) of any joint, so that the linearisation stays valid
  constexpr double kProgress = 1e-6;  // relative: a step that reduces the error by less has converged
  Task<M> now, candidate_task;
  task<M>(target, posture, now);
  double damping = 1e-4;  // m^2, against singular values of some 0.1 m; adapted as Levenberg and Marquardt do
  double error = now.error.norm();
  for (int k = 0; k < kMaxSteps && error > tolerance_m; ++k) {
    JointVector step = damped_step<M>(posture, now, now.error, damping);
    const double largest = step.cwiseAbs().maxCoeff();
    if (largest > kMaxStep) step *= kMaxStep / largest;
    const JointVector candidate = clamped(posture + step);
    task<M>(target, candidate, candidate_task);
    const double candidate_error = candidate_task.error.norm();
    if (candidate_error < error) {
      const bool arrived = error - candidate_error < kProgress * error && damping < 1e-6;
      posture = candidate;
      now = candidate_task;
      error = candidate_error;
      damping = std::max(damping * 0.2, 1e-15);
      if (arrived) break;
    } else {
      damping *= 8;
      if (damping > 1e4) break;
    }
  }
  return error;
}

template <int M>
void LevenbergMarquardtIk::approach_task(const TaskTarget& target, const JointVector& theta, JointVector& posture,
                                         double tolerance_m) const {
  constexpr int kMaxSteps = 40;
  double stride = 1;
  const auto squared_distance = [&](const JointVector& from) {
    return weight_.size() == 0 ? (from - theta).squaredNorm() : (from - theta).cwiseProduct(weight_).squaredNorm();
  };
  double distance = squared_distance(posture);
  Task<M> now;
  for (int k = 0; k < kMaxSteps && stride > 1e-3; ++k) {
    task<M>(target, posture, now);
    const JointVector wanted = stride * (theta - posture);
    // Remove the part of `wanted` that moves the end effector; damping keeps this finite at singularities.
    const Eigen::Matrix<double, M, 1> moved = now.jacobian * wanted;
    JointVector candidate = clamped(posture + wanted - damped_step<M>(posture, now, moved, 1e-9));
    const bool reaches = solve_task<M>(target, candidate, tolerance_m) <= tolerance_m;
    const double candidate_distance = squared_distance(candidate);
    if (reaches && candidate_distance < distance) {
      const bool settled = distance - candidate_distance < 1e-3 * distance + 1e-12;
      posture = candidate;
      distance = candidate_distance;
      stride = std::min(1.0, stride * 2);
      if (settled) break;
    } else {
      stride *= 0.5;
    }
  }
}

double LevenbergMarquardtIk::solve(const TaskTarget& target, JointVector& posture, double tolerance_m) const {
  return with_rows(target.task, [&]<int M>() { return solve_task<M>(target, posture, tolerance_m); });
}

void LevenbergMarquardtIk::approach(const TaskTarget& target, const JointVector& theta, JointVector& posture,
                                    double tolerance_m) const {
  with_rows(target.task, [&]<int M>() { approach_task<M>(target, theta, posture, tolerance_m); });
}

double LevenbergMarquardtIk::error(const TaskTarget& target, const JointVector& posture) const {
  return with_rows(target.task, [&]<int M>() {
    Task<M> now;
    task<M>(target, posture, now);
    return now.error.norm();
  });
}

}  // namespace multireach::controller
