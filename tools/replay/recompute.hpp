#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "runtime/node.hpp"
#include "runtime/nodes/robot_config.hpp"
#include "runtime/nodes/vision_node.hpp"
#include "tools/replay/recorded_log.hpp"

namespace multireach {

/// With what the nodes of a recorded run are made again.
struct NodeConfigs {
  RobotConfig robot;
  std::optional<VisionConfig> vision;
};

/// A fresh node of this name (vision, controller, bridge, ideal_robot); null for another name. Throws InputError where
/// it needs a vision file and there is none.
std::unique_ptr<Node> make_node(const std::string& name, const NodeConfigs& configs);

/// What a node sends, as it is computed. `certain` is false once an input was missing.
using ComputedSink = std::function<void(const OutMessage& message, bool certain)>;
/// The bytes of the message with this digest; empty where nobody has them.
using FindMessage = std::function<std::span<const uint8_t>(int64_t digest)>;

struct Recomputed {
  int64_t inputs = 0;
  int64_t missing = 0;  ///< inputs that are not in the log, or whose telling was lost
};

/// Computes a run again from what it took in, and goes on to tick until it has ticked `ticks` times.
Recomputed recompute(const RecordedRun& run, const NodeConfigs& configs, int64_t ticks, const FindMessage& find,
                     const ComputedSink& sink);

}  // namespace multireach
