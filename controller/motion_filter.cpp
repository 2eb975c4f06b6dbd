#include "controller/motion_filter.hpp"

#include <Eigen/Cholesky>
#include <limits>

namespace multireach::controller {
namespace {

/// Standard deviations of what is not known at first, m/s and m/s^2. With three of them a target of 1.2 m/s is still
/// the same one in the next image; 0.2 m in 0.75 s with minimum jerk need 0.5 m/s and 2 m/s^2.
constexpr double kSpeed = 0.4, kAcceleration = 4;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

}  // namespace

void MotionFilter::begin(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance,
                         const Eigen::Vector3d& velocity) {
  state_ << position, velocity, Eigen::Vector3d::Zero();
  covariance_.setZero();
  covariance_.topLeftCorner<3, 3>() = covariance;
  covariance_.diagonal().segment<3>(3).setConstant(kSpeed * kSpeed);
  covariance_.diagonal().tail<3>().setConstant(kAcceleration * kAcceleration);
}

void MotionFilter::predict(double seconds, double jerk_noise) {
  const double t = seconds, t2 = t * t, t3 = t2 * t;
  Matrix9 F = Matrix9::Identity();
  F.diagonal<3>().setConstant(t);
  F.diagonal<6>().setConstant(t2 / 2);
  state_ = (F * state_).eval();
  covariance_ = (F * covariance_ * F.transpose()).eval();
  Eigen::Matrix3d noise;  // of position, velocity and acceleration, on each axis
  noise << t2 * t3 / 20, t2 * t2 / 8, t3 / 6, t2 * t2 / 8, t3 / 3, t2 / 2, t3 / 6, t2 / 2, t;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) covariance_.block<3, 3>(3 * i, 3 * j).diagonal().array() += jerk_noise * noise(i, j);
  }
}

bool MotionFilter::correct(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d total = covariance_.topLeftCorner<3, 3>() + covariance;
  const auto factors = total.llt();
  if (factors.info() != Eigen::Success) return false;
  const Eigen::Matrix<double, 9, 3> gain = factors.solve(covariance_.topRows<3>()).transpose();
  state_ += gain * (position - state_.head<3>());
  covariance_ -= (gain * total * gain.transpose()).eval();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  return true;
}

double MotionFilter::squared_distance(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance) const {
  const auto factors = (covariance_.topLeftCorner<3, 3>() + covariance).eval().llt();
  if (factors.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3d apart = position - state_.head<3>();
  return apart.dot(factors.solve(apart));
}

}  // namespace multireach::controller
