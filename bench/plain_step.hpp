#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "kinematics/chain.hpp"

namespace multireach::bench {

/// The guarded step as one would first write it: the same attractors, bounds, coherence program and target posture, on
/// dynamic-size Eigen matrices and the plain kinematics of Chain. Something to compare the real one with.
class PlainStep {
 public:
  PlainStep(const Chain& chain, double gamma) : chain_(chain), gamma_(gamma) {}

  void start(const Eigen::VectorXd& theta, const Eigen::VectorXd& theta_target, const Eigen::Vector3d& target) {
    theta_ = theta;
    theta_target_ = theta_target;
    target_ = target;
    velocity_ = Eigen::VectorXd::Zero(chain_.size());
    hand_velocity_ = Eigen::VectorXd::Zero(3);
  }

  void step() {
    const int n = chain_.size();
    Eigen::MatrixXd J, J_T;
    const Eigen::VectorXd x = kinematics(theta_, J), x_T = kinematics(theta_target_, J_T);
    const Eigen::VectorXd wanted = velocity_ + kAlpha * (-velocity_ + kBeta * (theta_target_ - theta_));
    const Eigen::VectorXd hand = hand_velocity_ + kAlpha * (-hand_velocity_ + kBeta * (x_T - x));
    Eigen::VectorXd low(n), high(n);
    for (int i = 0; i < n; ++i) {
      const double speed = chain_.velocity()[i] / 140;
      high[i] = std::min(kRate / (1 + kRate) * (chain_.upper()[i] - theta_[i]), speed);
      low[i] = std::max(-kRate / (1 + kRate) * (theta_[i] - chain_.lower()[i]), -speed);
    }
    Eigen::VectorXd velocity(n);
    std::vector<bool> fixed(n, false);
    for (int round = 0; round < 2 * n; ++round) {
      Eigen::MatrixXd free = J;
      Eigen::VectorXd base = wanted;
      for (int i = 0; i < n; ++i) {
        if (!fixed[i]) continue;
        free.col(i).setZero();
        base[i] = velocity[i];
      }
      const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(3, 3) + gamma_ * free * free.transpose();
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
    const Eigen::VectorXd error = target_ - x_T, drift = 0.05 * (theta_ - theta_target_);
    const double damping = 1e-4 * std::min(1.0, error.squaredNorm() * 1e6) + 1e-12;
    const Eigen::MatrixXd B = J_T * J_T.transpose() + damping * Eigen::MatrixXd::Identity(3, 3);
    Eigen::VectorXd posture_step = drift + J_T.transpose() * B.llt().solve(error - J_T * drift);
    const double largest = posture_step.cwiseAbs().maxCoeff();
    if (largest > 0.05) posture_step *= 0.05 / largest;
    theta_target_ = (theta_target_ + posture_step).cwiseMax(chain_.lower()).cwiseMin(chain_.upper());
  }
  const Eigen::VectorXd& theta() const { return theta_; }

 private:
  static constexpr double kAlpha = 0.08, kBeta = 0.02, kRate = 0.04;

  Eigen::VectorXd kinematics(const Eigen::VectorXd& theta, Eigen::MatrixXd& jacobian) const {
    Eigen::Vector3d x;
    PositionJacobian J;
    chain_.position_and_jacobian(theta, x, J);
    jacobian = J;
    return x;
  }

  Chain chain_;
  double gamma_;
  Eigen::VectorXd theta_, theta_target_, velocity_, hand_velocity_;
  Eigen::Vector3d target_;
};

}  // namespace multireach::bench
