#include "vision/track/target_track.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace multireach::vision {
namespace {

constexpr int64_t kAnotherTimeLine = 1000000;  // us: a time this far before the last one is not a late pair
constexpr double kExpected = 7.8;              // 95 % of sightings are nearer, squared, in three dimensions
constexpr double kFastest = 12;                // m/s, of a target that is just found: a ball tossed to somebody
constexpr double kFirstSpeed = kFastest / 4;   // m/s, standard deviation of its velocity

double seconds_between(int64_t from, int64_t to) {
  return static_cast<double>(to - from) * 1e-6;
}

/// Of what is symmetric but for rounding: memory() keeps one half.
Eigen::Matrix<double, 6, 6> symmetric(const Eigen::Matrix<double, 6, 6>& matrix) {
  return matrix.selfadjointView<Eigen::Lower>();
}

}  // namespace

TargetTrack::TargetTrack(const Options& options) : options_(options) {
  const bool sensible = options.quiet_m2_s3 > 0 && options.unseen_m2_s3 >= options.quiet_m2_s3 &&
                        options.agile_m2_s3 >= options.unseen_m2_s3 && options.gate > 0 && options.confirmations > 0 &&
                        options.coast_s >= 0 && options.coast_sigma_m > 0;
  if (!sensible)
    throw std::invalid_argument("the track's options must be positive, and quiet at most unseen at most agile");
}

void TargetTrack::predict(double seconds, double noise, Vector6& state, Matrix6& covariance) const {
  Matrix6 F = Matrix6::Identity();
  F.topRightCorner<3, 3>().diagonal().setConstant(seconds);
  state = F * state_;
  covariance = F * covariance_ * F.transpose();
  covariance.topLeftCorner<3, 3>().diagonal().array() += noise * seconds * seconds * seconds / 3;
  covariance.topRightCorner<3, 3>().diagonal().array() += noise * seconds * seconds / 2;
  covariance.bottomLeftCorner<3, 3>().diagonal().array() += noise * seconds * seconds / 2;
  covariance.bottomRightCorner<3, 3>().diagonal().array() += noise * seconds;
  covariance = symmetric(covariance);
}

bool TargetTrack::correct(double seconds, const PlaceEstimate& seen) {
  for (double noise = options_.quiet_m2_s3;; noise = std::min(10 * noise, options_.agile_m2_s3)) {
    Vector6 state;
    Matrix6 covariance;
    predict(seconds, noise, state, covariance);
    const Eigen::Vector3d surprise = seen.position - state.head<3>();
    const Eigen::LDLT<Eigen::Matrix3d> total((covariance.topLeftCorner<3, 3>() + seen.covariance).eval());
    const double distance2 = surprise.dot(total.solve(surprise));
    const bool agile = noise >= options_.agile_m2_s3;
    if (!(distance2 <= (agile ? options_.gate * options_.gate : kExpected))) {
      if (agile) return false;
      continue;
    }
    const Eigen::Matrix<double, 6, 3> gain = total.solve(covariance.topRows<3>()).transpose();
    Matrix6 kept = Matrix6::Identity();
    kept.leftCols<3>() -= gain;
    state_ = state + gain * surprise;
    // Joseph's form stays positive.
    covariance_ = symmetric(kept * covariance * kept.transpose() + gain * seen.covariance * gain.transpose());
    return true;
  }
}

void TargetTrack::begin_at(const PlaceEstimate& seen, const Eigen::Vector3d& velocity, double velocity_variance) {
  state_ << seen.position, velocity;
  covariance_.setZero();
  covariance_.topLeftCorner<3, 3>() = seen.covariance.selfadjointView<Eigen::Lower>();
  covariance_.bottomRightCorner<3, 3>().diagonal().setConstant(velocity_variance);
}

bool TargetTrack::confirm(int64_t utime, const PlaceEstimate& seen) {
  const double seconds = seconds_between(stray_utime_, utime);
  const double sigma = std::sqrt(seen.covariance.trace());
  const Eigen::Vector3d moved = seen.position - stray_;
  const bool follows =
      strays_ > 0 && seconds <= options_.coast_s && moved.norm() <= kFastest * seconds + options_.gate * sigma;
  strays_ = follows ? strays_ + 1 : 1;
  stray_ = seen.position;
  stray_utime_ = utime;
  if (strays_ < options_.confirmations) return false;
  const double variance = follows ? 2 * sigma * sigma / (seconds * seconds) : kFirstSpeed * kFirstSpeed;
  begin_at(seen, follows ? (moved / seconds).eval() : Eigen::Vector3d::Zero().eval(), variance);
  return true;
}

bool TargetTrack::begins_anew(int64_t utime) const {
  return begun_ && utime < utime_ - kAnotherTimeLine;
}

bool TargetTrack::take(int64_t utime, const std::optional<PlaceEstimate>& seen, bool may_jump) {
  if (begins_anew(utime)) *this = TargetTrack(options_);
  if (begun_ && utime <= utime_) return false;
  const double seconds = begun_ ? seconds_between(utime_, utime) : 0;
  begun_ = true;
  utime_ = utime;
  const bool usable = seen && seen->position.allFinite() && seen->covariance.allFinite();
  bool taken = false;
  if (usable && status_ == Status::kLost) {
    begin_at(*seen, Eigen::Vector3d::Zero(), kFirstSpeed * kFirstSpeed);
    taken = true;
  } else if (usable) {
    taken = correct(seconds, *seen);
  }
  if (!taken && status_ != Status::kLost) {
    Vector6 state;
    Matrix6 covariance;
    predict(seconds, options_.unseen_m2_s3, state, covariance);
    state_ = state;
    covariance_ = covariance;
    taken = usable && may_jump && confirm(utime, *seen);
  }
  if (taken) {
    strays_ = 0;
    seen_utime_ = utime;
    status_ = Status::kTracked;
    return true;
  }
  if (status_ == Status::kLost) return false;
  const bool still = seconds_between(*seen_utime_, utime) <= options_.coast_s &&
                     place().covariance.trace() <= options_.coast_sigma_m * options_.coast_sigma_m;
  status_ = still ? Status::kCoasting : Status::kLost;
  if (!still) strays_ = 0;
  return false;
}

std::optional<PlaceEstimate> TargetTrack::expected(int64_t utime) const {
  if (status_ == Status::kLost || utime <= utime_) return std::nullopt;
  Vector6 state;
  Matrix6 covariance;
  predict(seconds_between(utime_, utime), options_.agile_m2_s3, state, covariance);
  return PlaceEstimate{state.head<3>(), covariance.topLeftCorner<3, 3>()};
}

namespace {

constexpr size_t kMemory = 35;

}  // namespace

std::vector<double> TargetTrack::memory() const {
  std::vector<double> memory{begun_ ? 1.0 : 0.0, static_cast<double>(status_),
                             seen_utime_ ? static_cast<double>(utime_ - *seen_utime_) : -1,
                             static_cast<double>(strays_), static_cast<double>(utime_ - stray_utime_)};
  memory.insert(memory.end(), stray_.begin(), stray_.end());
  memory.insert(memory.end(), state_.begin(), state_.end());
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column) memory.push_back(covariance_(row, column));
  }
  return memory;
}

bool TargetTrack::restore(int64_t utime, std::span<const double> memory) {
  const auto whole = [](double value, double least, double most) {
    return value >= least && value <= most && value == std::floor(value);
  };
  constexpr double kLongest = 9e15;  // us, as exact as a double is
  const bool valid = memory.size() == kMemory &&
                     std::ranges::all_of(memory, [](double v) { return std::isfinite(v); }) && whole(memory[0], 0, 1) &&
                     whole(memory[1], 0, 2) && whole(memory[2], -1, kLongest) &&
                     (memory[1] == 0 || (memory[0] == 1 && memory[2] >= 0)) && whole(memory[3], 0, 1e6) &&
                     whole(memory[4], -kLongest, kLongest);
  if (!valid) return false;
  begun_ = memory[0] > 0;
  status_ = static_cast<Status>(static_cast<int>(memory[1]));
  utime_ = utime;
  seen_utime_.reset();
  if (memory[2] >= 0) seen_utime_ = utime - static_cast<int64_t>(memory[2]);
  strays_ = static_cast<int>(memory[3]);
  stray_utime_ = utime - static_cast<int64_t>(memory[4]);
  stray_ = Eigen::Map<const Eigen::Vector3d>(&memory[5]);
  state_ = Eigen::Map<const Vector6>(&memory[8]);
  size_t k = 14;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column) covariance_(row, column) = covariance_(column, row) = memory[k++];
  }
  return true;
}

}  // namespace multireach::vision
