#pragma once

#include "kinematics/chain.hpp"

namespace multireach::robot_bridge {

/// The last thing before the robot. Its output moves by no more than each joint's speed limit allows in one period, and
/// is inside the position limits, or on the way there when it began outside.
class Guard {
 public:
  /// `speed_where_unlimited`: rad/s or m/s, for joints without a speed limit.
  Guard(const Chain& chain, double period_s, double speed_where_unlimited);

  /// The position nearest to `wanted` (finite, size() elements) that may follow `previous`; `limited` says whether it
  /// is another one than wanted.
  JointVector next(const JointVector& previous, const JointVector& wanted, bool& limited) const;

 private:
  JointVector lower_, upper_, largest_step_;
};

}  // namespace multireach::robot_bridge
