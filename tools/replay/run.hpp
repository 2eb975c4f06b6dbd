#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "runtime/robot_config.hpp"
#include "runtime/virtual_loop.hpp"
#include "tools/replay/session.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach {

/// How long a replay continues after the last input, so that messages in progress are completed, microseconds.
inline constexpr int64_t kDrainTime = 500000;

/// Where ROBOT_STATE comes from in a replay.
enum class ReplayRobot {
  kIdeal,      ///< a robot that follows its commands exactly
  kSimulated,  ///< MuJoCo; the bytes depend on the build of MuJoCo
  kRecorded,   ///< the states recorded in the session
};

struct ReplayOptions {
  std::string session;
  ReplayFrom from = ReplayFrom::kImages;
  ReplayRobot robot = ReplayRobot::kIdeal;
  RobotConfig config;
  std::optional<VisionConfig> vision;  ///< needed to replay from images
  double until_s = 1e9;                ///< end, seconds after the session's first input
  int threads = 1;                     ///< one runs the loop, the others decode images ahead of it
};

/// The result of a replay.
struct ReplayResult {
  struct Channel {
    int64_t messages = 0;
    int64_t digest = 0;  ///< of all its messages, in order
  };
  std::map<std::string, Channel, std::less<>> channels;  ///< channels with computed messages
  int64_t digest = 0;  ///< of all computed messages except NODE_INPUTS, with their channels and times
  int64_t inputs = 0;
  double span_s = 0;                             ///< duration of the session
  size_t damaged_bytes = 0, damaged_places = 0;  ///< of the session's log that were skipped
};

/// Creates the nodes of a replay, in the order in which they tick.
std::vector<std::unique_ptr<Node>> nodes_of(const ReplayOptions& options);

/// Adds the nodes to the loop; the robot has published its state once when the first input arrives.
void add_all(VirtualLoop& loop, const std::vector<std::unique_ptr<Node>>& nodes, const ReplayOptions& options);

/// Receives all messages of a replay in order; `input` is true for those taken from the session.
using ReplaySink =
    std::function<void(int64_t at_us, std::string_view channel, std::span<const uint8_t> bytes, bool input)>;
/// Called periodically with the part of the session done, 0 to 1.
using ReplayProgress = std::function<void(double)>;

/// Replays the whole session. Throws InputError when it cannot be read.
ReplayResult replay(const ReplayOptions& options, const ReplaySink& sink, const ReplayProgress& progress);

}  // namespace multireach
