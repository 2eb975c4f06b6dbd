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
int LevenbergMarquardtIk::descend_task(const TaskTarget& target, IkDescent& descent, double tolerance_m,
                                       int most) const {
  constexpr int kMaxSteps = 60;
  constexpr double kMaxStep = 0.5;    // rad (or m) of any joint, so that the linearisation stays valid
  constexpr double kProgress = 1e-6;  // relative: a step that reduces the error by less has converged
  Task<M> now, candidate_task;
  task<M>(target, descent.posture, now);  // again after an interruption: cheaper to compute than to keep
  double& error = descent.error;
  error = now.error.norm();
  const auto ended = [&] { return descent.steps >= kMaxSteps || !(error > tolerance_m); };
  descent.finished = ended();
  int work = 1;
  while (!descent.finished && work <= most) {
    JointVector step = damped_step<M>(descent.posture, now, now.error, descent.damping);
    const double largest = step.cwiseAbs().maxCoeff();
    if (largest > kMaxStep) step *= kMaxStep / largest;
    const JointVector candidate = clamped(descent.posture + step);
    task<M>(target, candidate, candidate_task);
    ++descent.steps;
    ++work;
    const double candidate_error = candidate_task.error.norm();
    bool converged = false;
    if (candidate_error < error) {
      converged = error - candidate_error < kProgress * error && descent.damping < 1e-6;
      descent.posture = candidate;
      now = candidate_task;
      error = candidate_error;
      descent.damping = std::max(descent.damping * 0.2, 1e-15);
    } else {
      descent.damping *= 8;
      converged = descent.damping > 1e4;
    }
    descent.finished = converged || ended();
  }
  return work;
}

template <int M>
int LevenbergMarquardtIk::approach_task(const TaskTarget& target, const JointVector& theta, IkApproach& run,
                                        double tolerance_m, int most) const {
  constexpr int kMaxStrides = 40;
  const auto squared_distance = [&](const JointVector& from) {
    return weight_.size() == 0 ? (from - theta).squaredNorm() : (from - theta).cwiseProduct(weight_).squaredNorm();
  };
  if (run.strides == 0) run.distance2 = squared_distance(run.posture);
  int work = 0;
  while (work < most) {
    if (!run.descends) {
      run.finished = run.finished || run.strides >= kMaxStrides || !(run.stride > 1e-3);
      if (run.finished) break;
      Task<M> now;
      task<M>(target, run.posture, now);
      ++work;
      const JointVector wanted = run.stride * (theta - run.posture);
      // Remove the part of `wanted` that moves the end effector; damping keeps this finite at singularities.
      const Eigen::Matrix<double, M, 1> moved = now.jacobian * wanted;
      run.candidate = IkDescent{clamped(run.posture + wanted - damped_step<M>(run.posture, now, moved, 1e-9))};
      run.descends = true;
      ++run.strides;
    }
    work += descend_task<M>(target, run.candidate, tolerance_m, std::max(1, most - work));
    if (!run.candidate.finished) continue;
    run.descends = false;
    const double distance2 = squared_distance(run.candidate.posture);
    if (run.candidate.error <= tolerance_m && distance2 < run.distance2) {
      run.finished = run.distance2 - distance2 < 1e-3 * run.distance2 + 1e-12;
      run.posture = run.candidate.posture;
      run.distance2 = distance2;
      run.stride = std::min(1.0, run.stride * 2);
    } else {
      run.stride *= 0.5;
    }
  }
  return work;
}

double LevenbergMarquardtIk::solve(const TaskTarget& target, JointVector& posture, double tolerance_m) const {
  IkDescent descent{posture};
  while (!descent.finished) descend(target, descent, tolerance_m, std::numeric_limits<int>::max());
  posture = descent.posture;
  return descent.error;
}

int LevenbergMarquardtIk::descend(const TaskTarget& target, IkDescent& descent, double tolerance_m, int most) const {
  return with_rows(target.task, [&]<int M>() { return descend_task<M>(target, descent, tolerance_m, most); });
}

int LevenbergMarquardtIk::approach(const TaskTarget& target, const JointVector& theta, IkApproach& run,
                                   double tolerance_m, int most) const {
  return with_rows(target.task, [&]<int M>() { return approach_task<M>(target, theta, run, tolerance_m, most); });
}

double LevenbergMarquardtIk::error(const TaskTarget& target, const JointVector& posture) const {
  return with_rows(target.task, [&]<int M>() {
    Task<M> now;
    task<M>(target, posture, now);
    return now.error.norm();
  });
}

}  // namespace multireach::controller
