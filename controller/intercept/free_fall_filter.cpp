#include "controller/intercept/free_fall_filter.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace multireach::controller {
namespace {

constexpr double kLeastSigma = 0.0005;   // m
constexpr double kLargestVariance = 1;   // m^2: an observation that tells less says nothing about a throw
constexpr double kFirstSpeed = 10;       // m/s: standard deviation of the velocity before the second observation
constexpr double kDisagreement = 16.27;  // chi squared with 3 degrees of freedom: one in a thousand
const double kEvidence = 2 * std::log(1000.0);
constexpr double kLongestGap = 0.3;  // s: what was seen longer ago says little about which throw this is

}  // namespace

FreeFallFilter::State FreeFallFilter::moved(const State& state, double seconds,
                                            const Eigen::Vector3d& acceleration) const {
  State next = state;
  next.head<3>() += seconds * state.tail<3>() + 0.5 * seconds * seconds * acceleration;
  next.tail<3>() += seconds * acceleration;
  return next;
}

/// The covariance after `seconds`, with the noise of a white acceleration.
FreeFallFilter::Covariance FreeFallFilter::spread(double seconds) const {
  Covariance F = Covariance::Identity();
  F.topRightCorner<3, 3>().diagonal().setConstant(seconds);
  Covariance spread = F * covariance_ * F.transpose();
  const double q = options_.other_acceleration * options_.other_acceleration, t = seconds;
  spread.topLeftCorner<3, 3>().diagonal().array() += q * t * t * t / 3;
  spread.topRightCorner<3, 3>().diagonal().array() += q * t * t / 2;
  spread.bottomLeftCorner<3, 3>().diagonal().array() += q * t * t / 2;
  spread.bottomRightCorner<3, 3>().diagonal().array() += q * t;
  return spread;
}

void FreeFallFilter::restart(const Eigen::Vector3d& position, const Eigen::Matrix3d& noise) {
  falling_ = {};
  falling_.state.head<3>() = position;
  steady_ = falling_;
  covariance_.setZero();
  covariance_.topLeftCorner<3, 3>() = noise;
  covariance_.bottomRightCorner<3, 3>().diagonal().setConstant(kFirstSpeed * kFirstSpeed);
  observations_ = 1;
}

void FreeFallFilter::observe(int64_t utime, const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance) {
  if (!position.allFinite() || (observations_ > 0 && utime <= utime_)) return;
  Eigen::Matrix3d noise = 0.5 * (covariance + covariance.transpose());
  if (noise.diagonal().maxCoeff() > kLargestVariance) return;
  if (!noise.allFinite() || noise.diagonal().minCoeff() < 0 || noise.llt().info() != Eigen::Success) noise.setZero();
  noise.diagonal().array() += kLeastSigma * kLeastSigma;
  const double seconds = 1e-6 * static_cast<double>(utime - utime_);
  utime_ = utime;
  if (observations_ == 0 || seconds > kLongestGap) return restart(position, noise);
  const Covariance predicted = spread(seconds);
  const Eigen::LLT<Eigen::Matrix3d> innovation(predicted.topLeftCorner<3, 3>() + noise);
  const auto surprise = [&](Estimate& estimate, const Eigen::Vector3d& acceleration) {
    estimate.state = moved(estimate.state, seconds, acceleration);
    const Eigen::Vector3d beside = position - estimate.state.head<3>();
    return beside.dot(innovation.solve(beside));
  };
  const double of_fall = surprise(falling_, options_.gravity), of_steady = surprise(steady_, Eigen::Vector3d::Zero());
  if (!(of_fall <= kDisagreement)) return restart(position, noise);
  falling_.surprise += of_fall;
  steady_.surprise += of_steady;
  const Eigen::Matrix<double, 6, 3> gain = innovation.solve(predicted.topRows<3>()).transpose();
  for (Estimate* estimate : {&falling_, &steady_})
    estimate->state += gain * (position - estimate->state.head<3>()).eval();
  covariance_ = predicted - gain * predicted.topRows<3>();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
  ++observations_;
}

bool FreeFallFilter::falls() const {
  return observations_ > 0 && steady_.surprise - falling_.surprise >= kEvidence;
}

std::optional<FallingBody> FreeFallFilter::at(int64_t utime) const {
  if (!falls()) return std::nullopt;
  const double seconds = 1e-6 * static_cast<double>(utime - utime_);
  const State state = moved(falling_.state, seconds, options_.gravity);
  return FallingBody{state.head<3>(), state.tail<3>(), spread(seconds).topLeftCorner<3, 3>()};
}

}  // namespace multireach::controller
