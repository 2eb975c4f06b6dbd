#include "controller/target_filter.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace multireach::controller {

namespace {

/// s: an acceleration is extrapolated no further. Three observations at 30 Hz and the way to the robot's motion.
constexpr double kLongestAcceleration = 0.15;
/// Of the estimate of a velocity that is not observed. m: standard deviation of a position whose covariance is not
/// known either, as of a colour detector at arm's length.
constexpr double kUnknownError = 2e-3;
constexpr double kAbsurd = 1e4;    // m^2: vision's own may have metres along the line of sight
constexpr double kLongestGap = 1;  // s: after a longer one the motion is unknown again
constexpr double kGate2 = 9;       // squared Mahalanobis distance of an observation that may still be the target's

/// Whether C is a valid covariance: finite, no element above kAbsurd, and positive semidefinite (no principal minor is
/// negative beyond rounding).
bool positive(const Eigen::Matrix3d& C) {
  if (!C.allFinite() || C.cwiseAbs().maxCoeff() > kAbsurd || C.diagonal().minCoeff() < 0) return false;
  const double largest = C.diagonal().maxCoeff(), rounding = 1e-9 * largest * largest;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (C(i, i) * C(j, j) - C(i, j) * C(i, j) < -rounding) return false;
  }
  return C.determinant() >= -rounding * largest;
}

}  // namespace

/// For how much of the time from the last observation to `utime` the target accelerates, s.
double TargetFilter::accelerated_s(int64_t utime) const {
  return std::clamp(static_cast<double>(utime - *utime_) * 1e-6, 0.0, kLongestAcceleration);
}

Eigen::Vector3d TargetFilter::position_at(int64_t utime) const {
  const double seconds = static_cast<double>(utime - *utime_) * 1e-6;
  const Eigen::Vector3d steady = position_ + velocity_ * seconds;
  if (!accelerates()) return steady;
  const double accelerated = accelerated_s(utime);
  return steady + acceleration_ * (accelerated * (seconds - accelerated / 2));
}

Eigen::Vector3d TargetFilter::velocity_at(int64_t utime) const {
  if (!accelerates()) return velocity_;
  return velocity_ + acceleration_ * accelerated_s(utime);
}

bool TargetFilter::is_jump(const Eigen::Vector3d& innovation, const Eigen::Matrix3d& noise) const {
  const double expected = 4 * std::sqrt(std::max(0.0, noise.trace()));
  return !(innovation.norm() <= std::max(options_.jump_m, expected));
}

/// As update(), for an observation without a velocity.
bool TargetFilter::estimate_motion(const TargetObservation& observation, const Eigen::Matrix3d& noise) {
  // positive() lets eigenvalues pass that are negative by 1e-9 of the largest element.
  const bool exact = noise.trace() <= 0;
  const double least = exact ? kUnknownError * kUnknownError : 1e-12 + 2e-9 * noise.diagonal().maxCoeff();
  const Eigen::Matrix3d error = noise + least * Eigen::Matrix3d::Identity();
  const double elapsed = utime_ ? std::max(0.0, static_cast<double>(observation.utime - *utime_) * 1e-6) : kLongestGap;
  bool jumped = !utime_;
  if (motion_ && elapsed < kLongestGap) {
    motion_->predict(elapsed, options_.jerk_noise_m2_s5);
    const bool far = is_jump(observation.position - motion_->position(), noise);
    jumped = far && !(motion_->squared_distance(observation.position, error) <= kGate2);
    if (jumped || !motion_->correct(observation.position, error)) motion_.reset();
  } else {
    jumped = jumped || is_jump(observation.position - position_at(observation.utime), noise);
    motion_.reset();
  }
  if (!motion_) motion_.emplace().begin(observation.position, error, jumped ? Eigen::Vector3d::Zero() : velocity_);
  position_ = exact ? observation.position : motion_->position();
  velocity_ = motion_->velocity();
  acceleration_ = motion_->acceleration();
  covariance_ = motion_->covariance().topLeftCorner<3, 3>();
  utime_ = observation.utime;
  return jumped;
}

bool TargetFilter::update(const TargetObservation& observation) {
  // An invalid covariance (negative, not finite, absurdly large) is ignored: the position counts as exact.
  Eigen::Matrix3d noise = 0.5 * (observation.covariance + observation.covariance.transpose());
  if (!positive(noise)) noise.setZero();
  if (options_.jerk_noise_m2_s5 > 0 && observation.velocity.isZero(0)) return estimate_motion(observation, noise);
  if (motion_) {
    motion_.reset();
    acceleration_.setZero();
  }
  const auto restart = [&] {
    position_ = observation.position;
    covariance_ = noise;
    return true;
  };
  bool jumped = !utime_;
  if (jumped) {
    restart();
  } else {
    const double elapsed = std::max(0.0, static_cast<double>(observation.utime - *utime_) * 1e-6);
    const Eigen::Vector3d predicted = position_at(observation.utime);
    const Eigen::Vector3d innovation = observation.position - predicted;
    covariance_.diagonal().array() += options_.wander_m_per_root_s * options_.wander_m_per_root_s * elapsed;
    const Eigen::Matrix3d total = covariance_ + noise;
    if (is_jump(innovation, noise)) {
      jumped = restart();
    } else if (const auto factors = total.llt(); noise.trace() <= 0 || factors.info() != Eigen::Success) {
      restart();
    } else {
      const Eigen::Matrix3d gain = factors.solve(covariance_).transpose();
      position_ = predicted + gain * innovation;
      covariance_ -= gain * covariance_;
      covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
    }
  }
  const double elapsed = utime_ ? static_cast<double>(observation.utime - *utime_) * 1e-6 : 0;
  if (jumped) {
    acceleration_.setZero();
  } else if (options_.acceleration_s > 0 && elapsed > 0) {
    const Eigen::Vector3d change = (observation.velocity - velocity_) / elapsed;
    acceleration_ += (1 - std::exp(-elapsed / options_.acceleration_s)) * (change - acceleration_);
  }
  velocity_ = observation.velocity;
  utime_ = observation.utime;
  return jumped;
}

}  // namespace multireach::controller
