#include "robot_bridge/guard.hpp"

#include <cmath>

namespace multireach::robot_bridge {

Guard::Guard(const Chain& chain, double period_s, double speed_where_unlimited)
    : lower_(chain.lower()), upper_(chain.upper()), largest_step_(chain.size()) {
  for (int i = 0; i < chain.size(); ++i) {
    const double speed = chain.velocity()[i];
    largest_step_[i] = period_s * (std::isfinite(speed) ? speed : speed_where_unlimited);
  }
}

JointVector Guard::next(const JointVector& previous, const JointVector& wanted, bool& limited) const {
  const JointVector inside = wanted.cwiseMax(lower_).cwiseMin(upper_);
  JointVector next = previous + (inside - previous).cwiseMax(-largest_step_).cwiseMin(largest_step_);
  // Tolerance: the rounding of previous + (inside - previous) does not count as limited.
  limited = ((next - wanted).cwiseAbs().array() > 1e-12 * (1 + wanted.cwiseAbs().array())).any();
  return next;
}

}  // namespace multireach::robot_bridge
