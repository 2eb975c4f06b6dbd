#pragma once

#include "kinematics/chain.hpp"

namespace multireach::robot_bridge {

/// The last stage before the robot. In one period, no joint of its output moves further than its speed limit allows.
/// The output is inside the position limits; when it starts outside, it moves towards them.
class Guard {
 public:
  /// `speed_where_unlimited`: rad/s or m/s, for joints without a speed limit.
  Guard(const Chain& chain, double period_s, double speed_where_unlimited);

  /// The allowed position after `previous` that is nearest to `wanted` (finite, size() elements). Sets `limited` when
  /// it differs from `wanted`.
  JointVector next(const JointVector& previous, const JointVector& wanted, bool& limited) const;

 private:
  JointVector lower_, upper_, largest_step_;
};

}  // namespace multireach::robot_bridge
