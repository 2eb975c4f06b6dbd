#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "kinematics/joint_vector.hpp"

namespace multireach {

/// One reach, from the change of its target on. `hand` is sampled every `tick_s` seconds, m; the first sample is where
/// the hand was when the target changed.
struct ReachMeasures {
  double error_m = 0;          ///< at the end
  double path_ratio = 1;       ///< path length over distance
  double settled_s = 0;        ///< from then on the hand stays within 1 % of the distance; the whole time for never
  double normalised_jerk = 0;  ///< sqrt(T^5 / (2 L^2) * integral of |jerk|^2) until settled, T: settled_s, L: path then
  int speed_peaks = 0;         ///< maxima of the hand's speed that stand out by 5 % of the largest
};
ReachMeasures measure_reach(std::span<const Eigen::Vector3d> hand, const Eigen::Vector3d& target, double tick_s);

/// Maxima of a series that rise and fall by `part` of its largest value.
int count_peaks(std::span<const double> values, double part);

/// Root mean square of the third derivative, by differences.
double rms_jerk(std::span<const Eigen::Vector3d> places, double tick_s);
double rms_jerk(std::span<const JointVector> postures, double tick_s);

/// The value below which the part q of the values is; not finite for none.
double quantile_of(std::vector<double> values, double q);

}  // namespace multireach
