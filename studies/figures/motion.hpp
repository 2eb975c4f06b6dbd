#pragma once

#include <span>
#include <vector>

#include "kinematics/chain.hpp"
#include "studies/figures/figure.hpp"

namespace multireach {

/// An arm at one time.
struct Moment {
  double time = 0;           ///< s
  JointVector theta;         ///< rad
  JointVector velocity;      ///< rad/s
  JointVector theta_target;  ///< theta_T, rad; empty for a measured arm
  Eigen::Vector3d x, x_dot;  ///< the hand, m and m/s, in W
};

/// An arm under way, at times that increase.
using Motion = std::vector<Moment>;

/// The moment of an arm at `theta` with `velocity` (rad/s).
Moment moment_of(const Chain& chain, double time, const JointVector& theta, const JointVector& velocity);
/// Between two moments everything is on a straight line; before the first and after the last nothing moves on.
Moment moment_at(const Motion& motion, double time);

/// Appends a set-point `tick_s` seconds after the last one, with the velocities that lead to it from there; the first
/// one has the time 0 and rests.
void append_setpoint(Motion& motion, double tick_s, const JointVector& theta, const Eigen::Vector3d& x);
/// The moments from `from` to `until`, s, both included.
Motion part(const Motion& motion, double from, double until);

/// Length of the hand's path, m.
double path_length(const Motion& motion);
/// Path length over the distance between the hand's first and last place; 1 is a straight line.
double straightness(const Motion& motion);
/// The largest distance of the hand from the line between its first and last place, over their distance.
double bulge(const Motion& motion);
/// The largest hand speed, m/s, and when, s.
struct SpeedPeak {
  double speed = 0, time = 0;
};
SpeedPeak speed_peak(const Motion& motion);
/// Maxima of a series of positive numbers that rise and fall by `share` of the largest.
int count_peaks(std::span<const double> values, double share);
/// How many maxima the hand's speed has; two count as one where it does not fall by 2 % of the largest between them.
int speed_peaks(const Motion& motion);
/// Root mean square of the jerk of the hand, m/s^3, and of all joints together, rad/s^3, by third differences; the
/// moments must be evenly spaced.
double hand_jerk(const Motion& motion);
double joint_jerk(const Motion& motion);
/// sqrt(T^5 / (2 L^2) * integral of |jerk of the hand|^2) for a movement out of rest, T: its duration, L: its path. Has
/// no unit, and so compares shapes. The moments must be evenly spaced.
double normalised_jerk(const Motion& motion);
/// The largest speed of any joint, rad/s.
double largest_joint_speed(const Motion& motion);
/// The largest change of any joint's velocity between two moments, rad/s.
double largest_velocity_step(const Motion& motion);
/// From when on the hand stays within `within` metres of `target`, s; NaN for never.
double settled_after(const Motion& motion, const Eigen::Vector3d& target, double within = 1e-3);

/// The same motion with the hand's velocity averaged over `window` seconds, as taken from two measured places.
Motion averaged(const Motion& motion, double window);

/// How two motions of one hand differ when the second is `delay` seconds behind.
struct Difference {
  double delay_s = 0, rms_m = 0, largest_m = 0;
  double rms_rad = 0, largest_rad = 0;  ///< of all joints together
};
/// The smallest RMS distance over all delays of whole milliseconds up to 0.2 s.
Difference difference(const Motion& wanted, const Motion& measured);

/// Adds what is asked of every reach: path / distance, peaks, peak speed and when, settling time, error at the end.
void add_reach_measures(Figure& figure, const std::string& law, const Motion& motion, const Eigen::Vector3d& target);

/// Appends numbers to a row of a table, each multiplied by `scale`.
void append(std::vector<double>& row, const Eigen::Ref<const Eigen::VectorXd>& values, double scale = 1);

}  // namespace multireach
