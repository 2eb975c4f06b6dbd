#include "controller/law/paper_law.hpp"

#include "controller/law/paper_equations.hpp"

namespace multireach::controller {

PaperState paper_state_at_rest(const Chain& chain, const JointVector& theta, const JointVector& theta_target) {
  return {.theta = theta,
          .theta_dot = JointVector::Zero(chain.size()),
          .x = chain.position(theta),
          .x_dot = Eigen::Vector3d::Zero(),
          .theta_target = theta_target};
}

JointVector paper_weights(const Chain& chain, const PaperParameters& parameters, const JointVector& theta) {
  if (parameters.limit_avoidance) return limit_weights(chain, theta, parameters.gamma);
  return JointVector::Constant(chain.size(), parameters.gamma);
}

void paper_step(const Chain& chain, const PaperParameters& parameters, const Eigen::Vector3d& x_T,
                const Eigen::Vector3d& x_T_velocity, PaperState& state) {
  const JointVector joint_velocity =
      vite_velocity(parameters.gains, state.theta, state.theta_dot, state.theta_target);             // (19), (20)
  const Eigen::Vector3d hand_velocity = vite_velocity(parameters.gains, state.x, state.x_dot, x_T);  // (21), (22)
  Eigen::Vector3d x;
  PositionJacobian jacobian;
  chain.position_and_jacobian(state.theta, x, jacobian);
  const JointVector weights = paper_weights(chain, parameters, state.theta);                               // (28)
  state.theta_dot = coherent_velocity(jacobian, weights, joint_velocity, hand_velocity);                   // (23)
  state.x_dot = jacobian * state.theta_dot;                                                                // (24)
  state.theta += state.theta_dot;                                                                          // (25)
  state.x = chain.position(state.theta);                                                                   // (26)
  state.theta_target = updated_target_posture(chain, state.theta_target, state.theta, x_T, x_T_velocity);  // (27)
}

}  // namespace multireach::controller
