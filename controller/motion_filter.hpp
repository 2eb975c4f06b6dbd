#pragma once

#include <Eigen/Core>

namespace multireach::controller {

/// Kalman filter of the position, velocity and acceleration of a target whose positions alone are observed: white noise
/// of its jerk (the discretised continuous Wiener process acceleration model, Bar-Shalom, Li & Kirubarajan, Estimation
/// with Applications to Tracking and Navigation, 2001, Sect. 6.2.3).
class MotionFilter {
 public:
  /// Begins with a first position, m, and the covariance of its error, m^2. Velocity and acceleration are unknown.
  void begin(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance);
  /// Goes on by `seconds`, not negative. `jerk_noise`: power spectral density of the jerk, m^2/s^5.
  void predict(double seconds, double jerk_noise);
  /// Takes a position observed now. The covariance must be positive definite.
  void correct(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance);

  Eigen::Vector3d position() const { return state_.head<3>(); }           ///< m
  Eigen::Vector3d velocity() const { return state_.segment<3>(3); }       ///< m/s
  Eigen::Vector3d acceleration() const { return state_.tail<3>(); }       ///< m/s^2
  Eigen::Matrix<double, 9, 9> covariance() const { return covariance_; }  ///< of position, velocity and acceleration

 private:
  Eigen::Matrix<double, 9, 1> state_ = Eigen::Matrix<double, 9, 1>::Zero();
  Eigen::Matrix<double, 9, 9> covariance_ = Eigen::Matrix<double, 9, 9>::Zero();
};

}  // namespace multireach::controller
