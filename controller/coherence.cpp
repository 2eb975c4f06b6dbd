#include "controller/coherence.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include "kinematics/trigonometry.hpp"

namespace multireach::controller {

JointVector limit_weights(const Chain& chain, const JointVector& theta, double gamma) {
  JointVector weights(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    const double lower = chain.lower()[i], upper = chain.upper()[i];
    if (!chain.joint(i).limited()) {
      weights[i] = gamma;
    } else if (theta[i] > lower && theta[i] < upper) {
      double sine, cosine;
      sine_and_cosine_of(2 * std::numbers::pi * (theta[i] - lower) / (upper - lower), sine, cosine);
      weights[i] = 0.5 * gamma * (1 - cosine);
    } else {
      weights[i] = 0;
    }
  }
  return weights;
}

Eigen::Matrix3d coherence_matrix(const PositionJacobian& jacobian, const JointVector& weights) {
  return Eigen::Matrix3d::Identity() + jacobian * weights.asDiagonal() * jacobian.transpose();
}

JointVector coherent_velocity(const PositionJacobian& jacobian, const JointVector& weights,
                              const JointVector& joint_velocity, const Eigen::Vector3d& hand_velocity) {
  const Eigen::Vector3d incoherence = hand_velocity - jacobian * joint_velocity;
  const Eigen::Vector3d lambda = coherence_matrix(jacobian, weights).llt().solve(incoherence);
  return joint_velocity + weights.cwiseProduct(jacobian.transpose() * lambda);
}

double condition_number(const Eigen::Matrix3d& matrix) {
  const Eigen::Vector3d eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
  return eigenvalues[2] / eigenvalues[0];
}

}  // namespace multireach::controller
