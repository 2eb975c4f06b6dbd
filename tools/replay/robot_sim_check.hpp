#pragma once

#include <multireach/robot_state_t.hpp>
#include <multireach/sim_step_t.hpp>
#include <optional>
#include <vector>

#include "robot_bridge/sim/robot_sim_node.hpp"
#include "tools/replay/recompute.hpp"

namespace multireach {

/// Computes states of the simulated robot again, each from the state before it and the commands that SIM_STEP says the
/// robot followed. Real robots send no SIM_STEP, and their states cannot be computed.
class RobotSimCheck {
 public:
  RobotSimCheck(const RobotConfig& robot, FindMessage find);

  /// The ROBOT_STATE that a step led to, encoded; `run`: that of the robot, where there is no state before. Nothing
  /// where the state before or a command is missing.
  [[nodiscard]] std::optional<std::vector<uint8_t>> compute(const sim_step_t& step, int64_t run);

 private:
  /// The sequence number of the command that was followed; nothing where the log does not have it.
  std::optional<int64_t> apply_recorded_command(int64_t digest);

  FindMessage find_;
  MujocoArm arm_;
  std::vector<double> start_;
};

}  // namespace multireach
