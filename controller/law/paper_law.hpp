#pragma once

#include "controller/law/vite.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

/// Parameters of the law `paper`: Eqs. (19)-(28) of Hersch & Billard (2008) as printed, for comparison with the paper.
/// It also reproduces the paper's behaviour beyond limits, at singular targets and at spurious attractors; see
/// docs/equations.md.
struct PaperParameters {
  ViteGains gains;
  double gamma = 350;           ///< rad^2/m^2; the paper's bifurcation value 0.035 in rad^2/cm^2
  bool limit_avoidance = true;  ///< false: the weight of every joint is gamma instead of (28); see Fig. 14
};

/// The state of the law. Velocities are per step.
struct PaperState {
  JointVector theta;         ///< joint angles
  JointVector theta_dot;     ///< joint velocity
  Eigen::Vector3d x;         ///< hand position K(theta), m, in W
  Eigen::Vector3d x_dot;     ///< hand velocity
  JointVector theta_target;  ///< theta_T
};

/// A state at rest at `theta` with theta_T = `theta_target` (each of chain.size() elements).
PaperState paper_state_at_rest(const Chain& chain, const JointVector& theta, const JointVector& theta_target);

/// The weights w_x / w_theta of the joints at `theta`, rad^2/m^2: (28), or constant without limit avoidance.
JointVector paper_weights(const Chain& chain, const PaperParameters& parameters, const JointVector& theta);

/// One integration step towards the hand target `x_T` (m, in W) that moves with `x_T_velocity` (m per step). Order:
/// (19)-(22) from the state; paper_weights at theta; (23), (24); (25), (26); (27) with the new theta.
void paper_step(const Chain& chain, const PaperParameters& parameters, const Eigen::Vector3d& x_T,
                const Eigen::Vector3d& x_T_velocity, PaperState& state);

}  // namespace multireach::controller
