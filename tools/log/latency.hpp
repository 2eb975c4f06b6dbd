#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace multireach {

/// Distribution of a delay.
struct DelayStatistics {
  int64_t count = 0;
  double p50_ms = 0, p95_ms = 0, p99_ms = 0, max_ms = 0;
};

/// The delay of each step from a stereo pair to the first command computed from it, over the targets that a tick of
/// the controller uses. "By arrival" is by the times at which the logger received the messages, "by message" by the
/// times in them: capture of the pair, nominal times of the set-point and of the command.
struct LatencyReport {
  struct Stage {
    std::string from, to;
    DelayStatistics by_arrival, by_message;  ///< with a count of 0 where there is no such time
  };
  /// A robot's own command channel, for robots whose protocol is LCM; by arrival.
  struct Wire {
    std::string channel;
    DelayStatistics period;  ///< from one message to the next
    DelayStatistics delay;   ///< from the newest JOINT_COMMAND to the message
  };
  int64_t targets = 0;          ///< TARGET messages in the log
  int64_t taken_up = 0;         ///< of them, named by a set-point
  int64_t without_command = 0;  ///< of these, with a set-point that no command names: the next one was quicker
  std::vector<Stage> stages;    ///< one after another, and the whole
  std::vector<Wire> wires;      ///< those that the log has

  nlohmann::json json() const;
  std::string table() const;
};

/// Reads the log of a run (control and image groups merged). Throws InputError when it cannot be read.
LatencyReport latency_of(const std::string& log_path);

}  // namespace multireach
