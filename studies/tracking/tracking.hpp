#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "studies/study/reach_sample.hpp"

namespace multireach {

/// How the hand followed a target that keeps moving, once it had reached it.
struct TrackingError {
  double rms_m = 0;  ///< distance of the hand from where the target was then
  double max_m = 0;
  double lag_s = 0;  ///< the time by which the hand is behind: the shift of the target that leaves the smallest rms
};

/// A closed path in a horizontal plane around a centre: cos(w t), sin(w t), or the figure 8: sin(w t), sin(2 w t) / 2.
struct TrackedPath {
  std::string name;
  double period_s = 2;
  bool eight = false;

  /// m and m/s at time t, s, for a path of this radius, m.
  Eigen::Vector3d position(double t, double radius) const;
  Eigen::Vector3d velocity(double t, double radius) const;
};

/// Targets at 30 Hz, whose image was taken 30 ms before the robot shows the motion, one period of the controller apart.
enum class Tracker {
  kReach,     ///< the controller with its defaults
  kTrack,     ///< the controller with the defaults of `motion: track`
  kFollower,  ///< damped least squares and a position gain, with the same speed, acceleration and position limits
};

/// Follows `path` around the hand's position at the joint configuration `start`. `knows_velocity`: whether the
/// observations hold the target's velocity. nullopt where the arm cannot reach the whole path.
std::optional<TrackingError> run_tracking(const Chain& chain, const JointVector& start, const TrackedPath& path,
                                          double radius_m, Tracker tracker, bool knows_velocity);

/// Every path and tracker, around `samples` places, which are the sampler's target postures around which the arm can
/// reach every path: median and 95th percentile over the places.
nlohmann::json run_tracking_study(const Chain& chain, const ReachSampler& sampler, int64_t samples, double radius_m);
/// The same as a Markdown table.
std::string tracking_table(const nlohmann::json& result);

}  // namespace multireach
