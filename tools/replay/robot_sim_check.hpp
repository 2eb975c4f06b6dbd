#pragma once

#include <multireach/robot_state_t.hpp>
#include <optional>
#include <vector>

#include "robot_bridge/sim/robot_sim_node.hpp"
#include "tools/replay/recompute.hpp"

namespace multireach {

/// Computes each state of the simulated robot again from the state before it and the commands that it says to have
/// followed. Real robots' states say no such thing, and cannot be.
class RobotSimCheck {
 public:
  RobotSimCheck(const RobotConfig& robot, FindMessage find);

  struct Outcome {
    bool simulated = false;
    bool equal = false;
    bool broken = false;                           ///< its check does not fit it
    std::optional<std::vector<uint8_t>> expected;  ///< what was computed, where that can be
  };
  Outcome check(const RecordedMessage& message);

 private:
  std::optional<std::vector<uint8_t>> compute(const robot_state_t& state);
  /// The sequence number of the command that was followed; nothing where nobody has it.
  std::optional<int64_t> follow_command(int64_t digest);

  FindMessage find_;
  MujocoArm arm_;
  std::vector<double> start_;
};

}  // namespace multireach
