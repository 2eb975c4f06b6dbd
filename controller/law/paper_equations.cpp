#include "controller/law/paper_equations.hpp"

#include <Eigen/Eigenvalues>
#include <array>
#include <limits>
#include <numbers>

#include "numeric/small_solve.hpp"
#include "numeric/trigonometry.hpp"

namespace multireach::controller {
namespace {

#include "controller/law/paper_equations.inl.hpp"

using Joints = std::array<double, kMaxJoints>;

Joints array_of(const JointVector& vector) {
  Joints joints{};
  for (int i = 0; i < vector.size(); ++i) joints[i] = vector[i];
  return joints;
}

std::array<Joints, 3> rows_of(const PositionJacobian& jacobian) {
  std::array<Joints, 3> rows{};
  for (int m = 0; m < 3; ++m) {
    for (int i = 0; i < jacobian.cols(); ++i) rows[m][i] = jacobian(m, i);
  }
  return rows;
}

JointVector vector_of(int n, const Joints& joints) {
  return Eigen::Map<const Eigen::VectorXd>(joints.data(), n);
}

}  // namespace

JointVector limit_weights(const Chain& chain, const JointVector& theta, double gamma) {
  JointVector weights(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    weights[i] = limit_weight(theta[i], chain.lower()[i], chain.upper()[i], gamma);
  }
  return weights;
}

Eigen::Matrix3d coherence_matrix(const PositionJacobian& jacobian, const JointVector& weights) {
  return Eigen::Matrix3d::Identity() + jacobian * weights.asDiagonal() * jacobian.transpose();
}

JointVector coherent_velocity(const PositionJacobian& jacobian, const JointVector& weights,
                              const JointVector& joint_velocity, const Eigen::Vector3d& hand_velocity) {
  const int n = static_cast<int>(joint_velocity.size());
  Joints velocity = array_of(joint_velocity);
  make_coherent(n, rows_of(jacobian), array_of(weights), {hand_velocity[0], hand_velocity[1], hand_velocity[2]},
                velocity);
  return vector_of(n, velocity);
}

JointVector updated_target_posture(const Chain& chain, const JointVector& theta_T, const JointVector& theta,
                                   const Eigen::Vector3d& x_T, const Eigen::Vector3d& x_T_velocity) {
  Eigen::Vector3d reached;
  PositionJacobian J;
  chain.position_and_jacobian(theta_T, reached, J);
  const Eigen::Vector3d missing = x_T_velocity + x_T - reached;
  Joints update;
  target_update(chain.size(), rows_of(J), array_of(theta_T), array_of(theta), {missing[0], missing[1], missing[2]},
                update);
  return theta_T + vector_of(chain.size(), update);
}

double condition_number(const Eigen::Matrix3d& matrix) {
  const Eigen::Vector3d eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
  return eigenvalues[2] / eigenvalues[0];
}

}  // namespace multireach::controller
