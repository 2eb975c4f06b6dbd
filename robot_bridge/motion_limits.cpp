#include "robot_bridge/motion_limits.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "kinematics/default_limits.hpp"

namespace multireach::robot_bridge {
namespace {

void check_positive(const JointVector& values, int size, const char* what) {
  if (values.size() != size)
    throw std::invalid_argument(std::string("the ") + what + " limits must have one value for each joint");
  for (const double value : values) {
    if (!(value > 0 && std::isfinite(value)))
      throw std::invalid_argument(std::string("every ") + what + " limit must be positive and finite");
  }
}

}  // namespace

MotionLimits motion_limits(const Chain& chain, double speed_where_unlimited, const JointVector& acceleration,
                           const JointVector& jerk) {
  MotionLimits limits{chain.lower(), chain.upper(), chain.velocity(), acceleration, jerk};
  for (double& velocity : limits.velocity) {
    if (!std::isfinite(velocity)) velocity = speed_where_unlimited;
  }
  check_positive(limits.velocity, chain.size(), "speed");
  if (acceleration.size() == 0) limits.acceleration = default_acceleration(limits.velocity);
  check_positive(limits.acceleration, chain.size(), "acceleration");
  if (jerk.size() == 0) limits.jerk = limits.acceleration / kDefaultTimeToAcceleration;
  check_positive(limits.jerk, chain.size(), "jerk");
  return limits;
}

}  // namespace multireach::robot_bridge
