#include "vision/track/target_track.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace multireach::vision {
namespace {

constexpr double kExpected = 7.8;             // 95 % quantile of chi^2 with three degrees of freedom
constexpr double kFastest = 12;               // m/s, largest speed of a target just found: a ball tossed to somebody
constexpr double kFirstSpeed = kFastest / 4;  // m/s, standard deviation of the velocity of a target just found
constexpr int64_t kJustBefore = 120000;       // us: between three and four pairs at 30 Hz
constexpr double kNearSpeed = kFirstSpeed;    // m/s, with which a target that rested can make a near jump

constexpr double kNearSigmas = 4;  // of a match, by which it may be farther than the target can have moved

double seconds_between(int64_t from, int64_t to) {
  return static_cast<double>(to - from) * 1e-6;
}

/// Makes a matrix exactly symmetric, because serialize() stores only the lower triangle.
Eigen::Matrix<double, 6, 6> symmetric(const Eigen::Matrix<double, 6, 6>& matrix) {
  return matrix.selfadjointView<Eigen::Lower>();
}

/// Its square root is symmetric: the one that changes little where the covariance does.
Eigen::Matrix3d root_of(const Eigen::Matrix3d& covariance) {
  if (covariance.isZero(0)) return Eigen::Matrix3d::Zero();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  const Eigen::Vector3d roots = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  return solver.eigenvectors() * roots.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace

TargetTrack::TargetTrack(const Options& options) : options_(options) {
  const bool sensible = options.min_process_noise_m2_s3 > 0 &&
                        options.coasting_process_noise_m2_s3 >= options.min_process_noise_m2_s3 &&
                        options.max_process_noise_m2_s3 >= options.coasting_process_noise_m2_s3 && options.gate > 0 &&
                        options.confirmations > 0 && options.coast_s >= 0 && options.coast_sigma_m > 0;
  if (!sensible)
    throw std::invalid_argument(
        "the track's options must be positive, with min_process_noise <= coasting_process_noise <= max_process_noise");
}

TargetTrack::Filter TargetTrack::predict(double seconds, double noise) const {
  Matrix6 F = Matrix6::Identity();
  F.topRightCorner<3, 3>().diagonal().setConstant(seconds);
  Matrix6 covariance = F * filter_.covariance * F.transpose();
  covariance.topLeftCorner<3, 3>().diagonal().array() += noise * seconds * seconds * seconds / 3;
  covariance.topRightCorner<3, 3>().diagonal().array() += noise * seconds * seconds / 2;
  covariance.bottomLeftCorner<3, 3>().diagonal().array() += noise * seconds * seconds / 2;
  covariance.bottomRightCorner<3, 3>().diagonal().array() += noise * seconds;
  return {F * filter_.state, symmetric(covariance), F * filter_.bias_factor};
}

bool TargetTrack::correct(double seconds, const PositionEstimate& seen, double least_noise) {
  const Eigen::Matrix3d bias_root = root_of(seen.bias_covariance);
  for (double noise = least_noise;; noise = std::min(10 * noise, options_.max_process_noise_m2_s3)) {
    const Filter before = predict(seconds, noise);
    Matrix6 covariance = before.covariance;
    if (seen.unbiased()) covariance += before.bias_factor * before.bias_factor.transpose();
    const Eigen::Vector3d innovation = seen.position - before.state.head<3>();
    const Eigen::LDLT<Eigen::Matrix3d> total((covariance.topLeftCorner<3, 3>() + seen.covariance).eval());
    const double distance2 = innovation.dot(total.solve(innovation));
    const bool manoeuvres = noise >= options_.max_process_noise_m2_s3;
    if (!(distance2 <= (manoeuvres ? options_.gate * options_.gate : kExpected))) {
      if (manoeuvres) return false;
      continue;
    }
    const Matrix63 gain = total.solve(covariance.topRows<3>()).transpose();
    Matrix6 kept = Matrix6::Identity();
    kept.leftCols<3>() -= gain;
    filter_.state = before.state + gain * innovation;
    // The Joseph form keeps the covariance positive definite.
    filter_.covariance =
        symmetric(kept * before.covariance * kept.transpose() + gain * seen.covariance * gain.transpose());
    filter_.bias_factor = kept * before.bias_factor + gain * bias_root;
    return true;
  }
}

void TargetTrack::begin_at(const PositionEstimate& seen, const Eigen::Vector3d& velocity, double velocity_variance,
                           Start start) {
  start_ = start;
  filter_ = Filter();
  filter_.state << seen.position, velocity;
  filter_.covariance.topLeftCorner<3, 3>() = seen.covariance.selfadjointView<Eigen::Lower>();
  filter_.covariance.bottomRightCorner<3, 3>().diagonal().setConstant(velocity_variance);
  filter_.bias_factor.topRows<3>() = root_of(seen.bias_covariance);
}

/// The largest speed of a target that collides with something.
double TargetTrack::top_speed() const {
  return std::max(kNearSpeed, velocity().norm());
}

/// Whether the target can have got to a measured position at a speed, within the errors of the measurement along this
/// way, and the track's bias if the measurement has none.
bool TargetTrack::can_reach(int64_t utime, const PositionEstimate& seen, double speed) const {
  if (!last_seen_utime_) return false;
  const Eigen::Vector3d way = seen.position - position_at(*last_seen_utime_);
  Eigen::Matrix3d covariance = seen.covariance;
  if (seen.unbiased()) covariance += estimate().bias_covariance;
  const double sigma_along = std::sqrt(way.normalized().dot(covariance * way.normalized()));
  return way.norm() <= speed * seconds_between(*last_seen_utime_, utime) + kNearSigmas * sigma_along;
}

bool TargetTrack::is_near(int64_t utime, const PositionEstimate& seen) const {
  return can_reach(utime, seen, top_speed());
}

bool TargetTrack::expects(int64_t utime, const PositionEstimate& seen) const {
  const auto there = predicted(utime);
  if (!there) return true;
  const Eigen::Vector3d innovation = seen.position - there->position;
  Eigen::Matrix3d total = there->covariance + seen.covariance;
  if (seen.unbiased()) total += there->bias_covariance;
  return innovation.dot(total.ldlt().solve(innovation)) <= options_.gate * options_.gate;
}

bool TargetTrack::was_just_seen(int64_t utime) const {
  return last_seen_utime_ && utime - *last_seen_utime_ <= kJustBefore;
}

bool TargetTrack::may_bounce_to(int64_t utime, const PositionEstimate& seen) const {
  constexpr double kSigmas = 2;
  constexpr double kLag = 1.5;  // the estimate lags behind a target that falls
  const double sigma = std::sqrt(velocity_covariance().trace() / 3);
  const double speed = std::min(top_speed(), kLag * velocity().norm() + kSigmas * sigma);
  return status_ == Status::kTracked && was_just_seen(utime) && can_reach(utime, seen, speed);
}

Eigen::Vector3d TargetTrack::position_at(int64_t utime) const {
  return filter_.state.head<3>() - seconds_between(utime, utime_) * velocity();
}

bool TargetTrack::confirm(int64_t utime, const PositionEstimate& seen, bool at_once) {
  const double seconds = seconds_between(outlier_utime_, utime);
  const double sigma = std::sqrt(seen.covariance.trace());
  const Eigen::Vector3d moved = seen.position - outlier_;
  const bool follows =
      outliers_ > 0 && seconds <= options_.coast_s && moved.norm() <= kFastest * seconds + kNearSigmas * sigma;
  outliers_ = follows ? outliers_ + 1 : 1;
  outlier_ = seen.position;
  outlier_utime_ = utime;
  const double larger = std::max(outlier_variance_, seen.covariance.trace());
  outlier_variance_ = seen.covariance.trace();
  if (at_once) {
    // All velocities up to the top speed are taken as equally likely: in a ball, a fifth of its radius squared each
    // way.
    begin_at(seen, Eigen::Vector3d::Zero(), top_speed() * top_speed() / 5, Start::kJumpAtOnce);
    return true;
  }
  const int all = options_.confirmations, needed = is_near(utime, seen) ? std::max(std::min(2, all), all - 1) : all;
  if (outliers_ < needed) return false;
  // One of the two may be a centroid, the other a contour.
  const double variance = follows ? 2 * larger / (seconds * seconds) : kFirstSpeed * kFirstSpeed;
  begin_at(seen, follows ? (moved / seconds).eval() : Eigen::Vector3d::Zero().eval(), variance, Start::kJump);
  return true;
}

bool TargetTrack::update(int64_t utime, const std::optional<PositionEstimate>& seen, Jump jump, bool elsewhere) {
  start_ = Start::kNone;
  if (begun_ && utime <= utime_) return false;
  const double seconds = begun_ ? seconds_between(utime_, utime) : 0;
  begun_ = true;
  utime_ = utime;
  const bool usable =
      seen && seen->position.allFinite() && seen->covariance.allFinite() && seen->bias_covariance.allFinite();
  bool taken = false;
  if (usable && status_ == Status::kLost) {
    begin_at(*seen, Eigen::Vector3d::Zero(), kFirstSpeed * kFirstSpeed, Start::kFirst);
    taken = true;
  } else if (usable && !elsewhere) {
    const bool poor = jump == Jump::kNever;  // it does not tell whether the target rests
    taken = correct(seconds, *seen, poor ? options_.coasting_process_noise_m2_s3 : options_.min_process_noise_m2_s3);
  }
  if (!taken && status_ != Status::kLost) {
    filter_ = predict(seconds, options_.coasting_process_noise_m2_s3);
    taken = usable && jump != Jump::kNever && confirm(utime, *seen, jump == Jump::kAtOnce);
  }
  if (taken) {
    outliers_ = 0;
    last_seen_utime_ = utime;
    status_ = Status::kTracked;
    return true;
  }
  if (status_ == Status::kLost) return false;
  const bool still = seconds_between(*last_seen_utime_, utime) <= options_.coast_s &&
                     estimate().covariance.trace() <= options_.coast_sigma_m * options_.coast_sigma_m;
  status_ = still ? Status::kCoasting : Status::kLost;
  if (!still) outliers_ = 0;
  return false;
}

void TargetTrack::lose() {
  status_ = Status::kLost;
  outliers_ = 0;
}

void TargetTrack::expire(int64_t utime) {
  constexpr double kPause = 0.5;  // s: the pairs of slow cameras are no pause
  if (status_ != Status::kLost && seconds_between(*last_seen_utime_, utime) > std::max(options_.coast_s, kPause))
    lose();
}

std::optional<PositionEstimate> TargetTrack::predicted(int64_t utime) const {
  return predicted_with(utime, options_.max_process_noise_m2_s3);
}

std::optional<PositionEstimate> TargetTrack::predicted_steady(int64_t utime) const {
  return predicted_with(utime, options_.coasting_process_noise_m2_s3);
}

std::optional<PositionEstimate> TargetTrack::predicted_with(int64_t utime, double noise) const {
  if (status_ == Status::kLost || utime <= utime_) return std::nullopt;
  return predict(seconds_between(utime_, utime), noise).position();
}

PositionEstimate TargetTrack::Filter::position() const {
  const Eigen::Matrix3d factor = bias_factor.topRows<3>();
  return {state.head<3>(), covariance.topLeftCorner<3, 3>(), factor * factor.transpose()};
}

PositionEstimate TargetTrack::estimate() const {
  return filter_.position();
}

PositionEstimate TargetTrack::estimate_before(int64_t utime) const {
  const double seconds = seconds_between(utime, utime_);
  PositionEstimate estimate = predict(-seconds, 0).position();
  estimate.covariance.diagonal().array() += options_.max_process_noise_m2_s3 * seconds * seconds * seconds / 3;
  return estimate;
}

TargetTrack::Status TargetTrack::unseen_status(int64_t utime) const {
  if (status_ == Status::kLost || seconds_between(utime, utime_) > options_.coast_s) return Status::kLost;
  return Status::kCoasting;
}

Eigen::Matrix3d TargetTrack::velocity_covariance() const {
  const Eigen::Matrix3d factor = filter_.bias_factor.bottomRows<3>();
  return filter_.covariance.bottomRightCorner<3, 3>() + factor * factor.transpose();
}

namespace {

constexpr size_t kSerializedSize = 54, kBiasFactor = 35;

}  // namespace

std::vector<double> TargetTrack::serialize() const {
  std::vector<double> state{begun_ ? 1.0 : 0.0, static_cast<double>(status_),
                            last_seen_utime_ ? static_cast<double>(utime_ - *last_seen_utime_) : -1,
                            static_cast<double>(outliers_), static_cast<double>(utime_ - outlier_utime_)};
  state.insert(state.end(), outlier_.begin(), outlier_.end());
  state.insert(state.end(), filter_.state.begin(), filter_.state.end());
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column) state.push_back(filter_.covariance(row, column));
  }
  const auto bias_factor = filter_.bias_factor.reshaped();
  state.insert(state.end(), bias_factor.begin(), bias_factor.end());
  state.push_back(outlier_variance_);
  return state;
}

bool TargetTrack::deserialize(int64_t utime, std::span<const double> state) {
  const auto whole = [](double value, double least, double most) {
    return value >= least && value <= most && value == std::floor(value);
  };
  constexpr double kLongest = 9e15;  // us; a double represents integers up to here exactly
  const bool valid = state.size() == kSerializedSize &&
                     std::ranges::all_of(state, [](double v) { return std::isfinite(v); }) && whole(state[0], 0, 1) &&
                     whole(state[1], 0, 2) && whole(state[2], -1, kLongest) &&
                     (state[1] == 0 || (state[0] == 1 && state[2] >= 0)) && whole(state[3], 0, 1e6) &&
                     whole(state[4], -kLongest, kLongest) &&
                     std::ranges::all_of(state.subspan(kBiasFactor, 18), [](double v) { return std::abs(v) < 1e6; }) &&
                     state.back() >= 0;
  if (!valid) return false;
  begun_ = state[0] > 0;
  status_ = static_cast<Status>(static_cast<int>(state[1]));
  utime_ = utime;
  last_seen_utime_.reset();
  if (state[2] >= 0) last_seen_utime_ = utime - static_cast<int64_t>(state[2]);
  outliers_ = static_cast<int>(state[3]);
  outlier_utime_ = utime - static_cast<int64_t>(state[4]);
  outlier_ = Eigen::Map<const Eigen::Vector3d>(&state[5]);
  filter_.state = Eigen::Map<const Vector6>(&state[8]);
  size_t k = 14;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column)
      filter_.covariance(row, column) = filter_.covariance(column, row) = state[k++];
  }
  filter_.bias_factor = Eigen::Map<const Matrix63>(&state[kBiasFactor]);
  outlier_variance_ = state.back();
  return true;
}

}  // namespace multireach::vision
