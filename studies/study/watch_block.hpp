#pragma once

#include "controller/batch/arm_block.hpp"
#include "studies/study/run_reach.hpp"

namespace multireach {

/// What is the same for all reaches that are watched.
struct WatchPlan {
  WatchPlan(const Chain& chain, const ReachRules& reach_rules);

  int n;
  ReachRules rules;
  std::array<double, kMaxJoints> lower, upper, speed;
};

/// ReachWatch for the arms of a block, each on its own reach: bit for bit what one ReachWatch each would say.
class WatchBlock {
 public:
  /// A reach begins in this lane; the block's arm has just been started.
  void begin(const controller::ArmBlock& block, int lane);
  /// Takes one step of all arms. Returns a mask: bit a is set where the reach of lane a is over.
  uint32_t take(const WatchPlan& plan, const controller::ArmBlock& block);
  ReachResult result(const WatchPlan& plan, int lane) const;

  // One row for each number of ReachResult, and what ReachWatch remembers.
  Row steps{}, settled_step{}, still_steps{}, limit_excess{}, velocity_excess{}, distance{}, path{}, error{}, finite{};
  std::array<Row, 3> last_x{};
};

}  // namespace multireach
