#pragma once

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <type_traits>
#include <vector>

#include "kinematics/chain.hpp"

namespace multireach::bench {

/// A straightforward implementation of the guarded step, as a baseline: the same attractors, bounds, coherence QP and
/// target posture, with Eigen matrices and the plain kinematics of Chain. `N`: the number of joints if known at compile
/// time, which avoids allocations.
template <int N = Eigen::Dynamic>
class PlainStep {
  using Joints = Eigen::Matrix<double, N, 1>;
  using Jacobian = std::conditional_t<N == Eigen::Dynamic, Eigen::MatrixXd, Eigen::Matrix<double, 3, N>>;
  using Task = std::conditional_t<N == Eigen::Dynamic, Eigen::VectorXd, Eigen::Vector3d>;
  using Square = std::conditional_t<N == Eigen::Dynamic, Eigen::MatrixXd, Eigen::Matrix3d>;

 public:
  PlainStep(const Chain& chain, double gamma) : chain_(chain), gamma_(gamma) {}

  void start(const Eigen::VectorXd& theta, const Eigen::VectorXd& theta_target, const Eigen::Vector3d& target) {
    theta_ = theta;
    theta_target_ = theta_target;
    target_ = target;
    velocity_ = Joints::Zero(chain_.size());
    hand_velocity_ = Task::Zero(3);
  }

  void step() {
    const int n = chain_.size();
    Jacobian J, J_T;
    const Task x = kinematics(theta_, J), x_T = kinematics(theta_target_, J_T);
    const Joints wanted = velocity_ + kAlpha * (-velocity_ + kBeta * (theta_target_ - theta_));
    const Task hand = hand_velocity_ + kAlpha * (-hand_velocity_ + kBeta * (x_T - x));
    Joints low(n), high(n);
    for (int i = 0; i < n; ++i) {
      const double speed = chain_.velocity()[i] / 140;
      high[i] = std::min(kRate / (1 + kRate) * (chain_.upper()[i] - theta_[i]), speed);
      low[i] = std::max(-kRate / (1 + kRate) * (theta_[i] - chain_.lower()[i]), -speed);
    }
    Joints velocity(n);
    std::conditional_t<N == Eigen::Dynamic, std::vector<bool>, std::array<bool, 16>> fixed{};
    if constexpr (N == Eigen::Dynamic) fixed.resize(static_cast<size_t>(n));
    for (int round = 0; round < 2 * n; ++round) {
      Jacobian free = J;
      Joints base = wanted;
      for (int i = 0; i < n; ++i) {
        if (!fixed[i]) continue;
        free.col(i).setZero();
        base[i] = velocity[i];
      }
      const Square A = Square::Identity(3, 3) + gamma_ * free * free.transpose();
      velocity = base + gamma_ * free.transpose() * A.llt().solve(hand - J * base);
      bool changed = false;
      for (int i = 0; i < n; ++i) {
        if (velocity[i] >= low[i] && velocity[i] <= high[i]) continue;
        velocity[i] = std::clamp(velocity[i], low[i], high[i]);
        fixed[i] = changed = true;
      }
      if (!changed) break;
    }
    velocity_ = velocity;
    hand_velocity_ = J * velocity;
    theta_ += velocity;
    const Task error = target_ - x_T;
    const Joints drift = 0.05 * (theta_ - theta_target_);
    const double damping = 1e-4 * std::min(1.0, error.squaredNorm() * 1e6) + 1e-12;
    const Square B = J_T * J_T.transpose() + damping * Square::Identity(3, 3);
    Joints posture_step = drift + J_T.transpose() * B.llt().solve(error - J_T * drift);
    const double largest = posture_step.cwiseAbs().maxCoeff();
    if (largest > 0.05) posture_step *= 0.05 / largest;
    theta_target_ = (theta_target_ + posture_step).cwiseMax(chain_.lower()).cwiseMin(chain_.upper());
  }
  const Joints& theta() const { return theta_; }

 private:
  static constexpr double kAlpha = 0.08, kBeta = 0.02, kRate = 0.04;

  Task kinematics(const Joints& theta, Jacobian& jacobian) const {
    Eigen::Vector3d x;
    PositionJacobian J;
    chain_.position_and_jacobian(theta, x, J);
    jacobian = J;
    return x;
  }

  Chain chain_;
  double gamma_;
  Joints theta_, theta_target_, velocity_;
  Task hand_velocity_;
  Eigen::Vector3d target_;
};

}  // namespace multireach::bench
