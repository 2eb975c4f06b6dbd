#pragma once

#include <map>
#include <multireach/robot_state_t.hpp>
#include <optional>
#include <vector>

#include "tools/replay/recompute.hpp"
#include "tools/robot_sim/robot_sim_node.hpp"

namespace multireach {

/// The commands that the recorded runs of the bridge sent, by their sequence.
class ComputedCommands {
 public:
  /// A run's commands come in order. `first_event`: where the log first tells of the run.
  void add(int64_t first_event, int64_t sequence, int64_t digest);
  /// The digest of the command that a message at `event` of the log means; nothing where there was none.
  std::optional<int64_t> find(int64_t event, int64_t sequence) const;

 private:
  std::map<int64_t, std::vector<int64_t>> runs_;
};

/// Computes each state of the simulated robot again from the state before it and the commands that it says to have
/// followed. Real robots' states say no such thing, and cannot be.
class RobotSimCheck {
 public:
  RobotSimCheck(const RobotConfig& robot, const ComputedCommands& commands, FindMessage find);

  struct Outcome {
    bool simulated = false;
    bool equal = false;
    bool broken = false;                           ///< its check does not fit it
    std::optional<std::vector<uint8_t>> expected;  ///< what was computed, where that can be
  };
  /// The states come in the order of the log.
  Outcome next(const RecordedMessage& message);

 private:
  std::optional<std::vector<uint8_t>> compute(const robot_state_t& state, int64_t event);
  bool follow_command(int64_t event, int64_t sequence);

  const ComputedCommands& commands_;
  FindMessage find_;
  MujocoArm arm_;
  std::vector<double> start_;
  std::optional<robot_state_t> before_;
};

}  // namespace multireach
