#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/log_file.hpp"

namespace multireach {

/// Edit logs in a single pass with constant memory; events of the output are numbered from 0. All functions throw
/// InputError when a log cannot be read or when the output is one of the inputs, and throw as OutputFile does.

/// Reports on standard error how much a reader at its end has skipped as damaged, if anything.
void report_damage(const std::string& path, const LogReader& reader);

/// Merges the events of several logs by time; for equal times, in the order of the logs. Of several logs, those that a
/// killed recorder left without a whole event are left out.
void merge_logs(const std::vector<std::string>& inputs, const std::string& output);
/// Keeps the events received from `from_s` until `until_s` after the first event, seconds. Returns their number.
int64_t cut_log(const std::string& input, const std::string& output, double from_s, double until_s);
/// Keeps the events of channels that match one of the shell patterns, e.g. "JOINT_*"; with `without`, those of all
/// other channels. Returns their number.
int64_t filter_log(const std::string& input, const std::string& output, const std::vector<std::string>& patterns,
                   bool without);

}  // namespace multireach
