#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tools/page/log_index.hpp"

namespace multireach {

/// The first difference between two runs of one session.
struct RunDifference {
  std::string channel, name;  ///< `name`: of a target
  int64_t utime = 0;          ///< message time, microseconds
  int64_t at_us = 0;          ///< time in the first run
  std::string field;          ///< as "joint_position[2]"
  std::string first, second;  ///< the values
};

/// Two runs of one session, message by message.
struct RunComparison {
  /// Add this to a time in the first run for the same moment in the second one, microseconds.
  int64_t offset_us = 0;
  int64_t compared = 0;  ///< messages of the same channel and message time
  std::optional<RunDifference> first;
  double hand_distance_m = 0;  ///< the largest, of CONTROLLER_STATE of one message time
  int64_t hand_at_us = 0;      ///< when, in the first run
};

/// The offset between the clocks of two runs' recorders: by the first target, image or set-point of a message time that
/// both have; 0 without one.
int64_t offset_between(const LogIndex& first, const LogIndex& second);

/// Compares the messages that have the same channel, sender and message time: targets, set-points, controller states,
/// commands, states of the bridge and the robot. What only counts or identifies (run numbers, sequence numbers, ticks)
/// may differ. `progress`: the part done, 0 to 1.
RunComparison compare_runs(const LogIndex& first, const LogIndex& second, const std::function<void(double)>& progress);

nlohmann::ordered_json json_of(const RunComparison& comparison);

}  // namespace multireach
