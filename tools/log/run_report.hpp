#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "runtime/log_file.hpp"
#include "runtime/robot_config.hpp"

namespace multireach {

/// Report on a recorded run: message counts, reaches with position error and settling time, vision error against ground
/// truth, intervals without target, limits, late ticks, lost messages. Times are message times in seconds from the
/// first TARGET.
struct RunReport {
  nlohmann::json json;
  /// Every reachable target was reached, and no command exceeded a limit.
  bool succeeded = false;
  std::string reason;  ///< a sentence: why the run did not succeed
};

/// Collects what the report on a run needs, message by message.
class RunReporter {
 public:
  explicit RunReporter(const RobotConfig& robot);
  ~RunReporter();
  /// The next event of the run, in the order of receipt.
  void add(const LogEvent& event);
  RunReport report() const;

 private:
  class Data;
  std::unique_ptr<Data> data_;
};

/// Reads the log of a run with this robot (control and image groups merged). Throws InputError when it cannot be read.
RunReport report_on(const std::string& log_path, const RobotConfig& robot);

/// The report as a human-readable table.
std::string table_of(const nlohmann::json& report);

}  // namespace multireach
