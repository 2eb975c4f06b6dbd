#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace multireach::vision {

/// A place with its uncertainty.
struct PlaceEstimate {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m, in W
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m^2
};

/// Follows one target over time: a Kalman filter of position and velocity on the capture times, whose acceleration is
/// white noise (Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001,
/// Sect. 6.2). The noise is that of a target at rest unless a sighting contradicts it; then it is raised, for that
/// step, as far as the sighting needs. What even a fast target cannot explain is a jump, and is believed only when
/// sightings after it confirm it.
class TargetTrack {
 public:
  struct Options {
    double quiet_m2_s3 = 1e-4;  ///< spectral density of the acceleration of a target at rest
    double agile_m2_s3 = 10;    ///< and of one that is thrown
    double unseen_m2_s3 = 0.1;  ///< and of one that is not seen
    double gate = 4;            ///< standard deviations beyond which a sighting is none of this target
    int confirmations = 3;      ///< sightings at a new place until they are believed
    double coast_s = 0.5;       ///< the longest time without a sighting
    double coast_sigma_m =
        0.1;  ///< and the largest standard deviation of the place: the root of its covariance's trace
  };
  enum class Status { kLost, kTracked, kCoasting };

  /// Throws std::invalid_argument when an option is not positive or a target at rest is not the quietest and a thrown
  /// one the most agile.
  explicit TargetTrack(const Options& options);

  /// Whether a pair of this time begins anew: it is more than a second before the last one, as when a log is played
  /// again.
  bool begins_anew(int64_t utime) const;
  /// Takes what was seen at `utime` (microseconds), or that nothing was. Returns false when that was not taken for the
  /// target: there was nothing, it was too far from where the target can be, or its time is not after the last one and
  /// does not begin anew.
  /// `may_jump`: it may be the target although it is elsewhere.
  bool take(int64_t utime, const std::optional<PlaceEstimate>& seen, bool may_jump = true);
  /// Where the target is expected at `utime`, if it is agile; nothing when it is lost.
  std::optional<PlaceEstimate> expected(int64_t utime) const;

  Status status() const { return status_; }
  /// Of the last pair taken, microseconds.
  int64_t utime() const { return utime_; }
  /// Of the last sighting that was taken for the target; nothing before the first.
  std::optional<int64_t> seen_utime() const { return seen_utime_; }
  /// At utime(). Meaningless when lost.
  PlaceEstimate place() const { return {state_.head<3>(), covariance_.topLeftCorner<3, 3>()}; }
  Eigen::Vector3d velocity() const { return state_.tail<3>(); }  ///< m/s, in W
  Eigen::Matrix3d velocity_covariance() const { return covariance_.bottomRightCorner<3, 3>(); }

  /// All that it remembers, so that another one can go on from here. Times are relative to utime().
  std::vector<double> memory() const;
  /// Goes on from a memory() at `utime`. Returns false, and changes nothing, when `memory` is none.
  bool restore(int64_t utime, std::span<const double> memory);

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  void predict(double seconds, double noise, Vector6& state, Matrix6& covariance) const;
  bool correct(double seconds, const PlaceEstimate& seen);
  bool confirm(int64_t utime, const PlaceEstimate& seen);
  void begin_at(const PlaceEstimate& seen, const Eigen::Vector3d& velocity, double velocity_variance);

  Options options_;
  Status status_ = Status::kLost;
  int64_t utime_ = 0;
  bool begun_ = false;
  std::optional<int64_t> seen_utime_;
  Vector6 state_ = Vector6::Zero();
  Matrix6 covariance_ = Matrix6::Zero();
  // Sightings that were too far away.
  int strays_ = 0;
  int64_t stray_utime_ = 0;
  Eigen::Vector3d stray_ = Eigen::Vector3d::Zero();
};

}  // namespace multireach::vision
