#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "controller/motion_filter.hpp"

namespace multireach::controller {

/// An observation of the target: its position at one time, or that it was not seen.
struct TargetObservation {
  int64_t utime = 0;                                     ///< microseconds
  bool seen = false;                                     ///< when false, the fields below are ignored
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m, in W
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();    ///< m/s, in W; zero when unknown
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m^2, of the position; zero for an exact position
  std::optional<Eigen::Matrix3d> orientation{};          ///< rotation from the target's frame to W, where it is known
};

/// Kalman filter of the position of a noisy target. It predicts with the observed velocity; a random walk is the
/// process noise. Where no velocity is observed, it may estimate it from the positions. Exact observations (zero
/// covariance) pass unchanged.
class TargetFilter {
 public:
  struct Options {
    double jump_m = 0.02;              ///< an innovation larger than this, and larger than four sigma of the
                                       ///< measurement noise, is a jump: the filter restarts there
    double wander_m_per_root_s = 0.1;  ///< process noise: standard deviation of the random walk after one second
    double acceleration_s = 0;         ///< the target's acceleration is the mean over about this time of how its
                                       ///< observed velocity changes; 0: no acceleration is assumed
    double jerk_noise_m2_s5 = 0;       ///< of a target whose velocity is not observed: MotionFilter estimates velocity
                                       ///< and acceleration with this noise; 0: they count as zero
  };
  explicit TargetFilter(const Options& options) : options_(options) {}

  /// Takes an observation, which must be seen and finite. Returns true when the target is new or has jumped.
  bool update(const TargetObservation& observation);
  /// Position, m, and velocity, m/s, of the target at `utime`, extrapolated. Call update() first.
  Eigen::Vector3d position_at(int64_t utime) const;
  Eigen::Vector3d velocity_at(int64_t utime) const;
  void reset() {
    utime_.reset();
    motion_.reset();
  }

 private:
  double accelerated_s(int64_t utime) const;
  bool accelerates() const { return options_.acceleration_s > 0 || options_.jerk_noise_m2_s5 > 0; }
  bool estimate_motion(const TargetObservation& observation, const Eigen::Matrix3d& noise);
  bool is_jump(const Eigen::Vector3d& innovation, const Eigen::Matrix3d& noise) const;

  Options options_;
  std::optional<int64_t> utime_;
  Eigen::Vector3d position_ = Eigen::Vector3d::Zero(), velocity_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_ = Eigen::Vector3d::Zero();  // m/s^2
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
  std::optional<MotionFilter> motion_;  // while no velocity is observed
};

}  // namespace multireach::controller
