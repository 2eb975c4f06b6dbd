#include "vision/track/exposure_skew.hpp"

namespace multireach::vision {

Eigen::Matrix3d unknown_velocity_covariance() {
  constexpr double kUnknownSpeed = 0.5;  // m/s
  return Eigen::Matrix3d::Identity() * kUnknownSpeed * kUnknownSpeed;
}

Eigen::Matrix3d covariance_of_skew(const StereoRig& rig, const Eigen::Vector3d& p_W,
                                   const Eigen::Matrix3d& velocity_covariance, double later_s) {
  const Eigen::Vector3d line = rig.X_WL.linear() * (rig.X_WL.inverse() * p_W);
  const double ratio = line.norm() / rig.baseline_m();
  const Eigen::Vector3d along = line.normalized();
  return along * along.transpose() * (velocity_covariance.trace() / 3 * later_s * later_s * ratio * ratio);
}

}  // namespace multireach::vision
