#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

namespace multireach::controller {

/// Where an object in free fall is at one time.
struct FallingObject {
  Eigen::Vector3d position;    ///< m, in W
  Eigen::Vector3d velocity;    ///< m/s, in W
  Eigen::Matrix3d covariance;  ///< m^2, of the position
};

/// Kalman filter of the position and velocity of an object in free fall, from noisy positions. A second one, of an
/// object that a hand moves, estimates its acceleration as well. The object falls when the evidence for the first
/// against the second is very strong: a Bayes factor of 150 (Kass and Raftery, "Bayes factors", 1995), which for these
/// two is the density of the gravity among the accelerations that the observations leave possible, divided by that
/// among all that a hand may have (Savage-Dickey density ratio). It starts anew after two observations in a row that
/// disagree with free fall: a hand, a bounce, another throw.
class FreeFallFilter {
 public:
  struct Options {
    Eigen::Vector3d gravity{0, 0, -9.81};  ///< m/s^2, in W
    /// m/s^2 in a bandwidth of 1 Hz: accelerations besides, as a white noise. Drag is not modelled: at 3 m/s the air
    /// slows a ball for tennis (58 g, 67 mm) down by 0.2 m/s^2, one for table tennis (2.7 g, 40 mm) by 1.1.
    double other_acceleration = 0.2;
  };
  explicit FreeFallFilter(const Options& options) : options_(options) {}

  /// Takes an observed position, m, in W, and its covariance, m^2. Ignored are positions that are not finite or not
  /// newer, microseconds, than the last, covariances that are not finite or not positive semidefinite, and variances
  /// above 1 m^2. (0.5 mm)^2 is added to each variance.
  void observe(int64_t utime, const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance);
  /// Whether the observations show that the object falls.
  bool falls() const { return falls_; }
  /// The object at any time from the last observation on; nullopt unless it falls.
  std::optional<FallingObject> at(int64_t utime) const;
  int64_t last_seen() const { return utime_; }
  void reset();

 private:
  using State = Eigen::Matrix<double, 9, 1>;  // position, velocity, acceleration
  using Covariance = Eigen::Matrix<double, 9, 9>;
  struct Estimate {
    State mean = State::Zero();
    Covariance covariance = Covariance::Zero();
  };
  Estimate predicted(const Estimate& estimate, double seconds) const;
  void restart(const Eigen::Vector3d& position, const Eigen::Matrix3d& noise);
  bool evidence_of_fall() const;

  Options options_;
  int64_t utime_ = 0;
  int observations_ = 0;  // since the last start
  bool falls_ = false, disagreed_ = false;
  Estimate falling_, moved_;  // the acceleration of the first is the gravity
};

}  // namespace multireach::controller
