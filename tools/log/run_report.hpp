#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "runtime/robot_config.hpp"

namespace multireach {

/// What happened in a recorded run: counts, places reached with error and settling time, vision against truth, lost
/// intervals, limits, late ticks, lost messages. Times are message times in seconds from the first TARGET.
struct RunReport {
  nlohmann::json json;
  /// Every reachable place was reached, and no limit was passed by a command.
  bool succeeded = false;
  std::string reason;  ///< why not, a sentence
};

/// Reads the log of a run (control and image groups merged) of this robot. Throws InputError when it cannot be read.
RunReport report_on(const std::string& log_path, const RobotConfig& robot);

/// The report as a table for people.
std::string table_of(const nlohmann::json& report);

}  // namespace multireach
