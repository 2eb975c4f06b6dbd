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

/// How long a replay goes on after the last input, for what is still on its way, microseconds.
inline constexpr int64_t kAfterwards = 500000;

/// Where ROBOT_STATE comes from in a replay.
enum class ReplayRobot {
  kIdeal,      ///< a robot that is where it was told to be
  kSimulated,  ///< MuJoCo's; its bytes are those of one build of MuJoCo
  kRecorded,   ///< the session's own
};

struct ReplayOptions {
  std::string session;
  ReplayFrom from = ReplayFrom::kImages;
  ReplayRobot robot = ReplayRobot::kIdeal;
  RobotConfig config;
  std::optional<VisionConfig> vision;  ///< needed to replay from images
  double until_s = 1e9;                ///< of the session, seconds after its first input
  int threads = 1;                     ///< 2 or more: vision computes beside the others
};

/// What a replay did.
struct ReplayResult {
  struct Channel {
    int64_t messages = 0;
    int64_t digest = 0;  ///< of all its messages in their order
  };
  std::map<std::string, Channel, std::less<>> channels;  ///< computed ones
  int64_t digest = 0;  ///< of all computed messages but NODE_INPUTS, with their channels and times
  int64_t inputs = 0;
  double span_s = 0;  ///< of the session
};

/// The nodes of a replay, fresh, in the order in which they tick.
std::vector<std::unique_ptr<Node>> nodes_of(const ReplayOptions& options);

/// A loop of these nodes, in which the robot has said once where it is when the first input comes.
void add_all(VirtualLoop& loop, const std::vector<std::unique_ptr<Node>>& nodes, const ReplayOptions& options);

/// Everything that a replay gives, in its order: `input` is true for what came from the session.
using ReplaySink =
    std::function<void(int64_t at_us, std::string_view channel, std::span<const uint8_t> bytes, bool input)>;
/// Called now and then with the part of the session that is done, 0 to 1.
using ReplayProgress = std::function<void(double)>;

/// Computes the whole session again. Throws InputError when it cannot be read.
ReplayResult replay(const ReplayOptions& options, const ReplaySink& sink, const ReplayProgress& progress);

}  // namespace multireach
