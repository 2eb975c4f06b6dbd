#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

namespace multireach::controller {

/// Where the target is at a time, or that it is not seen.
struct TargetObservation {
  int64_t utime = 0;                                     ///< microseconds
  bool seen = false;                                     ///< when false, the rest means nothing
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< m, in W
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();    ///< m/s, in W; zero where it is not known
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< m^2, of the position; zero for an exact position
};

/// Where a noisy target is: a Kalman filter of the position, carried along by the velocity that the observations bring,
/// with a random walk for what that velocity does not say. Exact observations pass unchanged.
class TargetFilter {
 public:
  struct Options {
    double jump_m = 0.02;              ///< a target that moves further between two observations, and further than
                                       ///< their noise explains (four sigma), has jumped
    double wander_m_per_root_s = 0.1;  ///< standard deviation of the random walk after one second
  };
  explicit TargetFilter(const Options& options) : options_(options) {}

  /// Takes an observation that is seen and finite. Returns true when the target is new or has jumped.
  bool update(const TargetObservation& observation);
  /// Where the target is at `utime`: carried along by its velocity.
  Eigen::Vector3d position_at(int64_t utime) const;
  const Eigen::Vector3d& velocity() const { return velocity_; }
  void forget() { utime_.reset(); }

 private:
  Options options_;
  std::optional<int64_t> utime_;
  Eigen::Vector3d position_ = Eigen::Vector3d::Zero(), velocity_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
};

}  // namespace multireach::controller
