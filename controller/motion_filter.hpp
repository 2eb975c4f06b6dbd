#pragma once

#include <Eigen/Core>

namespace multireach::controller {

/// Kalman filter of the position, velocity and acceleration of a target whose positions alone are observed: white noise
/// of its jerk (the discretised continuous Wiener process acceleration model, Bar-Shalom, Li & Kirubarajan, Estimation
/// with Applications to Tracking and Navigation, 2001, Sect. 6.2.3).
class MotionFilter {
 public:
  /// Begins with a first position, m, and the covariance of its error, m^2. The velocity, m/s, is hardly known, and the
  /// acceleration is unknown.
  void begin(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance, const Eigen::Vector3d& velocity);
  /// Predicts by `seconds`, not negative. `jerk_noise`: power spectral density of the jerk, m^2/s^5.
  void predict(double seconds, double jerk_noise);
  /// Corrects with a position observed now. Returns false, and changes nothing, when the covariance of the innovation
  /// is not positive definite.
  bool correct(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance);
  /// Squared Mahalanobis distance of a position observed now from the predicted one; infinite where that covariance is
  /// not positive definite.
  double squared_distance(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance) const;

  Eigen::Vector3d position() const { return state_.head<3>(); }           ///< m
  Eigen::Vector3d velocity() const { return state_.segment<3>(3); }       ///< m/s
  Eigen::Vector3d acceleration() const { return state_.tail<3>(); }       ///< m/s^2
  Eigen::Matrix<double, 9, 9> covariance() const { return covariance_; }  ///< of position, velocity and acceleration

 private:
  Eigen::Matrix<double, 9, 1> state_ = Eigen::Matrix<double, 9, 1>::Zero();
  Eigen::Matrix<double, 9, 9> covariance_ = Eigen::Matrix<double, 9, 9>::Zero();
};

}  // namespace multireach::controller
