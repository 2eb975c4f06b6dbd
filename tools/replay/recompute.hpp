#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "runtime/node.hpp"
#include "runtime/robot_config.hpp"
#include "tools/replay/recorded_log.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach {

/// The configurations from which the nodes of a recorded run are created again.
struct NodeConfigs {
  RobotConfig robot;
  std::optional<VisionConfig> vision;
};

/// Creates a node by name (vision, controller, bridge, ideal_robot); null for another name. Throws InputError when a
/// vision file is needed and not given.
std::unique_ptr<Node> make_node(const std::string& name, const NodeConfigs& configs);

/// The bytes of the message with this digest; empty when unknown.
using FindMessage = std::function<std::span<const uint8_t>(int64_t digest)>;

/// Callbacks of a recomputation: access to the log, and results.
struct Recomputation {
  FindMessage find;
  /// The recorded message of the node with this sequence number; empty if there is none.
  std::function<std::span<const uint8_t>(int64_t sequence)> recorded;
  /// Called when the recorded message with this sequence number was used unchecked to restore the node's state.
  std::function<void(int64_t sequence)> restored{};
  /// Called when the message with this sequence number cannot be computed, because an input that it may depend on is
  /// missing. Only for a node that sends a fixed number of messages per input.
  std::function<void(int64_t sequence)> uncomputable{};
  /// Called for each computed message; `certain` is false while an input that it may depend on is missing. Returns
  /// whether the message is in the log.
  std::function<bool(const OutMessage& message, bool certain)> sent;
};

struct Recomputed {
  int64_t inputs = 0;
  int64_t missing = 0;   ///< inputs that are not in the log, or whose NODE_INPUTS was lost
  int64_t restored = 0;  ///< inputs replaced by the recorded outputs for them
  bool certain = true;   ///< at the end, the node's state no longer depends on a missing input
};

/// Computes a run again from its recorded inputs, then continues to tick as long as the log contains the outputs.
Recomputed recompute(const RecordedRun& run, const NodeConfigs& configs, const Recomputation& io);

}  // namespace multireach
