#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "runtime/node.hpp"
#include "runtime/robot_config.hpp"
#include "tools/replay/recorded_log.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach {

/// With what the nodes of a recorded run are made again.
struct NodeConfigs {
  RobotConfig robot;
  std::optional<VisionConfig> vision;
};

/// A fresh node of this name (vision, controller, bridge, ideal_robot); null for another name. Throws InputError where
/// it needs a vision file and there is none.
std::unique_ptr<Node> make_node(const std::string& name, const NodeConfigs& configs);

/// The bytes of the message with this digest; empty where nobody has them.
using FindMessage = std::function<std::span<const uint8_t>(int64_t digest)>;

/// What a recomputation needs to know of the log, and whom it tells.
struct Recomputation {
  FindMessage find;
  /// The message that the node is recorded to have sent with this sequence number; empty where it is not.
  std::function<std::span<const uint8_t>(int64_t sequence)> recorded;
  /// The message with this sequence number was taken as it is recorded.
  std::function<void(int64_t sequence)> adopted{};
  /// What it sent with this sequence number cannot be computed: something is missing that it may depend on. Only of a
  /// node whose messages are counted by those that it takes in.
  std::function<void(int64_t sequence)> doubtful{};
  /// A message, as the node sends it; `certain` is false while something is missing that it may depend on. Returns
  /// whether it is in the log.
  std::function<bool(const OutMessage& message, bool certain)> sent;
};

struct Recomputed {
  int64_t inputs = 0;
  int64_t missing = 0;  ///< inputs that are not in the log, or whose telling was lost
  int64_t adopted = 0;  ///< inputs in whose place what was sent for them was taken
  bool certain = true;  ///< in the end, nothing is missing that what it sends may depend on
};

/// Computes a run again from what it took in, and goes on to tick for as long as the log knows what it sends.
Recomputed recompute(const RecordedRun& run, const NodeConfigs& configs, const Recomputation& io);

}  // namespace multireach
