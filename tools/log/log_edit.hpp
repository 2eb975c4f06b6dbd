#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/log_file.hpp"

namespace multireach {

/// Logs made from logs, event by event in constant memory; events are numbered anew. All throw InputError when a log
/// cannot be read or written, or when the output is one of the inputs.

/// Says on standard error what a reader that has come to the end has left out as damaged, if anything.
void say_damage(const std::string& path, const LogReader& reader);

/// The events of several logs in the order of their times (and of the logs, for equal times).
void merge_logs(const std::vector<std::string>& inputs, const std::string& output);
/// The events that the logger received from `from_s` until `until_s` after the first, seconds. Returns how many.
int64_t cut_log(const std::string& input, const std::string& output, double from_s, double until_s);
/// The events of the channels whose names match one of the shell patterns, as "JOINT_*"; `without`: of all others.
/// Returns how many.
int64_t filter_log(const std::string& input, const std::string& output, const std::vector<std::string>& patterns,
                   bool without);

}  // namespace multireach
