#pragma once

#include "controller/batch/arm_block.hpp"
#include "studies/study/run_reach.hpp"

namespace multireach {

/// The constants common to all monitored reaches.
struct MonitorConstants {
  MonitorConstants(const Chain& chain, const ReachRules& reach_rules);

  int n;
  ReachRules rules;
  std::array<double, kMaxJoints> lower, upper, speed;
};

/// A ReachMonitor for each arm of a block; the results are bit-identical to those of ReachMonitor.
class MonitorBlock {
 public:
  /// Begins a reach in this lane. Call it just after starting the lane's arm.
  void begin(const controller::ArmBlock& block, int lane);
  /// Evaluates one step of all arms. Returns a mask: bit a is set when the reach of lane a is over.
  uint32_t update(const MonitorConstants& constants, const controller::ArmBlock& block);
  ReachResult result(const MonitorConstants& constants, int lane) const;

  // One row for each field of ReachResult and each state variable of ReachMonitor.
  Row steps{}, settled_step{}, still_steps{}, limit_excess{}, velocity_excess{}, distance{}, path{}, error{}, finite{};
  std::array<Row, 3> last_x{};
};

}  // namespace multireach
