#include "controller/intercept/free_fall_filter.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace multireach::controller {
namespace {

constexpr double kLeastSigma = 0.0005;   // m: no camera system is better
constexpr double kLargestVariance = 1;   // m^2
constexpr double kFirstSpeed = 10;       // m/s: standard deviation of the velocity before the second observation
constexpr double kHandAcceleration = 6;  // m/s^2: of the acceleration that a hand gives, in each direction (assumed)
constexpr double kDisagreement = 16.27;  // chi squared with 3 degrees of freedom: one in a thousand
const double kEvidence = std::log(150.0);
constexpr double kLongestGap = 0.3;  // s: what was seen longer ago may be another throw

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Twice the negative logarithm of a normal density, without the constant.
double deviance(const Vector3d& from_mean, const Matrix3d& covariance) {
  const Eigen::LLT<Matrix3d> factors(covariance);
  const Vector3d diagonal = factors.matrixLLT().diagonal();
  return from_mean.dot(factors.solve(from_mean)) + 2 * diagonal.array().log().sum();
}

}  // namespace

void FreeFallFilter::reset() {
  observations_ = 0;
  falls_ = disagreed_ = false;
}

/// The estimate after `seconds` at constant acceleration, with the noise of a white acceleration.
FreeFallFilter::Estimate FreeFallFilter::predicted(const Estimate& estimate, double seconds) const {
  const double t = seconds, q = options_.other_acceleration * options_.other_acceleration;
  Covariance F = Covariance::Identity();
  F.block<3, 3>(0, 3).diagonal().setConstant(t);
  F.block<3, 3>(3, 6).diagonal().setConstant(t);
  F.block<3, 3>(0, 6).diagonal().setConstant(t * t / 2);
  Estimate next{F * estimate.mean, F * estimate.covariance * F.transpose()};
  next.covariance.block<3, 3>(0, 0).diagonal().array() += q * t * t * t / 3;
  next.covariance.block<3, 3>(0, 3).diagonal().array() += q * t * t / 2;
  next.covariance.block<3, 3>(3, 0).diagonal().array() += q * t * t / 2;
  next.covariance.block<3, 3>(3, 3).diagonal().array() += q * t;
  return next;
}

void FreeFallFilter::restart(const Vector3d& position, const Matrix3d& noise) {
  reset();
  falling_ = {};
  falling_.mean.head<3>() = position;
  falling_.covariance.block<3, 3>(0, 0) = noise;
  falling_.covariance.block<3, 3>(3, 3).diagonal().setConstant(kFirstSpeed * kFirstSpeed);
  moved_ = falling_;
  falling_.mean.tail<3>() = options_.gravity;
  moved_.covariance.block<3, 3>(6, 6).diagonal().setConstant(kHandAcceleration * kHandAcceleration);
  observations_ = 1;
}

void FreeFallFilter::observe(int64_t utime, const Vector3d& position, const Matrix3d& covariance) {
  if (!position.allFinite() || !covariance.allFinite() || (observations_ > 0 && utime <= utime_)) return;
  if (covariance.diagonal().maxCoeff() > kLargestVariance) return;
  Matrix3d noise = 0.5 * (covariance + covariance.transpose());
  noise.diagonal().array() += kLeastSigma * kLeastSigma;
  if (noise.llt().info() != Eigen::Success) return;
  const double seconds = 1e-6 * static_cast<double>(utime - utime_);
  if (observations_ == 0 || seconds > kLongestGap) {
    utime_ = utime;
    return restart(position, noise);
  }
  const Estimate falling = predicted(falling_, seconds);
  const Matrix3d total = falling.covariance.topLeftCorner<3, 3>() + noise;
  const Vector3d innovation = position - falling.mean.head<3>();
  if (!(innovation.dot(total.llt().solve(innovation)) <= kDisagreement)) {
    // One wrong observation does not end a flight.
    if (falls_ && !std::exchange(disagreed_, true)) return;
    utime_ = utime;
    return restart(position, noise);
  }
  disagreed_ = false;
  utime_ = utime;
  const auto update = [&](Estimate& estimate, const Estimate& before) {
    const Eigen::LLT<Matrix3d> innovations(before.covariance.topLeftCorner<3, 3>() + noise);
    const Eigen::Matrix<double, 9, 3> gain = innovations.solve(before.covariance.topRows<3>()).transpose();
    estimate.mean = before.mean + gain * (position - before.mean.head<3>());
    estimate.covariance = before.covariance - gain * before.covariance.topRows<3>();
    estimate.covariance = (0.5 * (estimate.covariance + estimate.covariance.transpose())).eval();
  };
  update(falling_, falling);
  update(moved_, predicted(moved_, seconds));
  ++observations_;
  falls_ = evidence_of_fall();
}

bool FreeFallFilter::evidence_of_fall() const {
  const Matrix3d left = moved_.covariance.bottomRightCorner<3, 3>(),
                 any = kHandAcceleration * kHandAcceleration * Matrix3d::Identity();
  const double ratio = deviance(options_.gravity, any) - deviance(options_.gravity - moved_.mean.tail<3>(), left);
  return observations_ > 2 && ratio / 2 >= kEvidence;
}

std::optional<FallingObject> FreeFallFilter::at(int64_t utime) const {
  if (!falls_) return std::nullopt;
  const Estimate then = predicted(falling_, 1e-6 * static_cast<double>(utime - utime_));
  return FallingObject{then.mean.head<3>(), then.mean.segment<3>(3), then.covariance.topLeftCorner<3, 3>()};
}

}  // namespace multireach::controller
