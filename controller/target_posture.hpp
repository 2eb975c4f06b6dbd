#pragma once

#include "kinematics/chain.hpp"

namespace multireach::controller {

/// One update of the target posture, Eq. (27), with tau = 1 and a plain inverse of J_T J_T^T: towards `theta` along the
/// postures that reach `x_T`, and back to them. Literal: it is not finite where J_T has not full rank (a stretched
/// arm), knows no limits, and may take a step of any size; callers must check what they get.
JointVector updated_target_posture(const Chain& chain, const JointVector& theta_T, const JointVector& theta,
                                   const Eigen::Vector3d& x_T, const Eigen::Vector3d& x_T_velocity);

}  // namespace multireach::controller
