#pragma once

#include "kinematics/chain.hpp"

namespace multireach::controller {

/// The n weight ratios w_x / w_theta of Eq. (28) at `theta`, in the unit of `gamma` (rad^2/m^2). They are zero at a
/// limit and outside the limits, where Eq. (28) taken literally would increase again; `gamma` for a continuous joint;
/// zero for a joint with an empty range.
JointVector limit_weights(const Chain& chain, const JointVector& theta, double gamma);

/// The matrix that coherence inverts, Eq. (31), with W_x = I: I + J W J^T, 3 x 3.
Eigen::Matrix3d coherence_matrix(const PositionJacobian& jacobian, const JointVector& weights);

/// The coherent joint velocity nearest to the velocities of both attractors, Eq. (23) with W_x = I: the minimum of Eq.
/// (6) under x' = J theta'. `weights` is the diagonal of W_theta^-1 (all >= 0).
JointVector coherent_velocity(const PositionJacobian& jacobian, const JointVector& weights,
                              const JointVector& joint_velocity, const Eigen::Vector3d& hand_velocity);

/// Condition number of a symmetric positive definite 3 x 3 matrix, as in Fig. 13 and Eq. (32).
double condition_number(const Eigen::Matrix3d& matrix);

/// One update of theta_T, Eq. (27), with tau = 1 and a plain inverse of J_T J_T^T: it moves theta_T towards `theta`
/// along its self-motion and corrects the hand's error to `x_T`. As printed in the paper: the result is not finite
/// where J_T lacks full rank (a stretched arm), ignores joint limits, and may be a step of any size. Callers must check
/// it.
JointVector updated_target_posture(const Chain& chain, const JointVector& theta_T, const JointVector& theta,
                                   const Eigen::Vector3d& x_T, const Eigen::Vector3d& x_T_velocity);

}  // namespace multireach::controller
