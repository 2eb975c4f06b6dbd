#pragma once

#include <span>
#include <vector>

#include "kinematics/chain.hpp"
#include "studies/figures/figure.hpp"

namespace multireach {

/// The state of an arm at one time.
struct Moment {
  double time = 0;           ///< s
  JointVector theta;         ///< rad
  JointVector velocity;      ///< rad/s
  JointVector theta_target;  ///< theta_T, rad; empty for a measured arm
  Eigen::Vector3d x, x_dot;  ///< position and velocity of the hand, m and m/s, in W
};

/// A trajectory of an arm, with increasing times.
using Motion = std::vector<Moment>;

/// The moment of an arm at `theta` with `velocity` (rad/s).
Moment moment_of(const Chain& chain, double time, const JointVector& theta, const JointVector& velocity);
/// The state at `time`, by linear interpolation; constant before the first and after the last moment.
Moment moment_at(const Motion& motion, double time);

/// Appends a set-point `tick_s` seconds after the last one, with velocities by finite differences. The first set-point
/// has time 0 and zero velocity.
void append_setpoint(Motion& motion, double tick_s, const JointVector& theta, const Eigen::Vector3d& x);
/// The moments from `from` to `until`, s, both included.
Motion part(const Motion& motion, double from, double until);

/// Length of the hand's path, m.
double path_length(const Motion& motion);
/// Path length divided by the distance between the hand's first and last position; 1 for a straight line.
double straightness(const Motion& motion);
/// The largest distance of the hand from the line between its first and last position, divided by their distance.
double bulge(const Motion& motion);
/// The largest hand speed, m/s, and its time, s.
struct SpeedPeak {
  double speed = 0, time = 0;
};
SpeedPeak speed_peak(const Motion& motion);
/// Number of maxima of a series of positive numbers; values must rise and fall by `share` of the largest to count.
int count_peaks(std::span<const double> values, double share);
/// Number of maxima of the hand's speed. Two count as one when the speed falls by less than 2 % of the largest between
/// them.
int speed_peaks(const Motion& motion);
/// Root mean square of the jerk of the hand, m/s^3, and of all joints together, rad/s^3, by third differences; the
/// moments must be evenly spaced.
double hand_jerk(const Motion& motion);
double joint_jerk(const Motion& motion);
/// sqrt(T^5 / (2 L^2) * integral of |jerk of the hand|^2) for a movement that starts at rest, T: its duration, L: its
/// path length. It is dimensionless, so it compares the shapes of movements. The moments must be evenly spaced.
double normalised_jerk(const Motion& motion);
/// The largest speed of any joint, rad/s.
double largest_joint_speed(const Motion& motion);
/// The largest change of any joint's velocity between two moments, rad/s.
double largest_velocity_step(const Motion& motion);
/// The time from which the hand stays within `within` metres of `target`, s; NaN for never.
double settled_after(const Motion& motion, const Eigen::Vector3d& target, double within = 1e-3);

/// The same motion with the hand's velocity averaged over `window` seconds, as computed from two measured positions.
Motion averaged(const Motion& motion, double window);

/// The difference between two motions of one arm when the second lags by `delay_s`.
struct Difference {
  double delay_s = 0, rms_m = 0, largest_m = 0;
  double rms_rad = 0, largest_rad = 0;  ///< of all joints together
};
/// The difference at the delay with the smallest RMS distance, over all whole milliseconds up to 0.2 s.
Difference difference(const Motion& wanted, const Motion& measured);

/// Adds the measures of every reach: path / distance, speed peaks, peak speed and its time, settling time, final error.
void add_reach_measures(Figure& figure, const std::string& law, const Motion& motion, const Eigen::Vector3d& target);

/// Appends numbers to a row of a table, each multiplied by `scale`.
void append(std::vector<double>& row, const Eigen::Ref<const Eigen::VectorXd>& values, double scale = 1);

}  // namespace multireach
