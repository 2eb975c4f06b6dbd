#pragma once

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
  /// How many runs there are.
  size_t runs() const { return runs_.size(); }
  /// The newest run that the log has told of at an event.
  size_t run_at(int64_t event) const;
  /// The digest of a run's command; nothing where there was none.
  std::optional<int64_t> find(size_t run, int64_t sequence) const;

 private:
  struct Run {
    int64_t first_event;
    std::vector<int64_t> digests;
  };
  std::vector<Run> runs_;
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
  /// As if the last command before the state had been one of this run of the bridge.
  std::optional<std::vector<uint8_t>> compute(const robot_state_t& state, size_t run);
  bool follow_command(size_t run, int64_t sequence);

  const ComputedCommands& commands_;
  FindMessage find_;
  MujocoArm arm_;
  std::vector<double> start_;
  std::optional<robot_state_t> before_;
};

}  // namespace multireach
