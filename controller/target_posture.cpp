#include "controller/target_posture.hpp"

#include <Eigen/LU>

namespace multireach::controller {

JointVector updated_target_posture(const Chain& chain, const JointVector& theta_T, const JointVector& theta,
                                   const Eigen::Vector3d& x_T, const Eigen::Vector3d& x_T_velocity) {
  Eigen::Vector3d reached;
  PositionJacobian J;
  chain.position_and_jacobian(theta_T, reached, J);
  const Eigen::Matrix3d inverse = (J * J.transpose()).inverse();
  const JointVector difference = theta_T - theta;
  // J^T (J J^T)^-1 [J (theta_T - theta) + tau x_T' + x_T - K(theta_T)] - (theta_T - theta), added to theta_T.
  const Eigen::Vector3d along = inverse * (J * difference + x_T_velocity + x_T - reached);
  return theta_T + (J.transpose() * along - difference);
}

}  // namespace multireach::controller
