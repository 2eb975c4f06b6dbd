#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

namespace multireach::controller {

/// Where a body in free fall is at one time.
struct FallingBody {
  Eigen::Vector3d position;    ///< m, in W
  Eigen::Vector3d velocity;    ///< m/s, in W
  Eigen::Matrix3d covariance;  ///< m^2, of the position
};

/// Kalman filter of the position and velocity of a body in free fall, from noisy positions. It also decides whether the
/// body falls at all: the observations must agree with free fall, and be a thousand times as likely under it as under a
/// velocity that is constant (Bayes factor: Kass and Raftery, "Bayes factors", 1995). It starts anew at an observation
/// that does not agree: a body in a hand, a bounce, another throw.
class FreeFallFilter {
 public:
  struct Options {
    Eigen::Vector3d gravity{0, 0, -9.81};  ///< m/s^2, in W
    /// m/s^2 in a bandwidth of 1 Hz: accelerations that are not gravity, as a white noise. The air slows a ball of 2.7
    /// g and 40 mm (table tennis) down by 1 m/s^2 at 3 m/s, one of 60 g and 65 mm (tennis) by 0.2.
    double other_acceleration = 0.2;
  };
  explicit FreeFallFilter(const Options& options) : options_(options) {}

  /// Takes an observed position, m, in W; finite, and of a later time, microseconds, than the last (others are
  /// ignored). A covariance that is zero or invalid counts as (0.5 mm)^2.
  void observe(int64_t utime, const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance);
  /// Whether the observations show that the body falls.
  bool falls() const;
  /// The body at any time from the last observation on; nullopt unless it falls.
  std::optional<FallingBody> at(int64_t utime) const;
  int64_t last_seen() const { return utime_; }
  void reset() { observations_ = 0; }

 private:
  using State = Eigen::Matrix<double, 6, 1>;  // position, velocity
  using Covariance = Eigen::Matrix<double, 6, 6>;
  struct Estimate {
    State state = State::Zero();
    double surprise = 0;  // twice the negative logarithm of the innovations' densities, less what both models share
  };
  State moved(const State& state, double seconds, const Eigen::Vector3d& acceleration) const;
  Covariance spread(double seconds) const;
  void restart(const Eigen::Vector3d& position, const Eigen::Matrix3d& noise);

  Options options_;
  int64_t utime_ = 0;
  int observations_ = 0;  // since the last start
  Estimate falling_, steady_;
  Covariance covariance_ = Covariance::Zero();  // of both: it does not depend on the acceleration
};

}  // namespace multireach::controller
