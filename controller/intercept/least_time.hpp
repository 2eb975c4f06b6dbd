#pragma once

#include <algorithm>
#include <cmath>

#include "kinematics/joint_vector.hpp"

namespace multireach::controller {

/// The least time, s, in which a joint at rest moves by `distance`, rad or m, with this speed and acceleration, without
/// stopping there.
inline double least_time(double distance, double speed, double acceleration) {
  const double until_full = speed * speed / (2 * acceleration);
  if (distance <= until_full) return std::sqrt(2 * distance / acceleration);
  return speed / acceleration + (distance - until_full) / speed;
}

/// The same for a change of all joint positions from rest: no motion within these limits is there sooner.
inline double least_time(const JointVector& change, const JointVector& speed, const JointVector& acceleration) {
  double longest = 0;
  for (Eigen::Index i = 0; i < change.size(); ++i)
    longest = std::max(longest, least_time(std::abs(change[i]), speed[i], acceleration[i]));
  return longest;
}

}  // namespace multireach::controller
