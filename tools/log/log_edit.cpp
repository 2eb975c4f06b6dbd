#include "tools/log/log_edit.hpp"

#include <fnmatch.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>

#include "runtime/files.hpp"
#include "runtime/log_file.hpp"
#include "runtime/progress.hpp"

namespace multireach {
namespace {

void refuse_to_overwrite(const std::string& input, const std::string& output) {
  std::error_code error;
  if (std::filesystem::equivalent(input, output, error)) {
    throw InputError(output + ": is a log that is read and cannot be written over");
  }
}

template <class Keep>
int64_t copy_if(const std::string& input, const std::string& output, Keep&& keep) {
  refuse_to_overwrite(input, output);
  LogReader reader(input);
  LogWriter writer(output);
  int64_t written = 0;
  Progress progress;
  while (const auto event = reader.next()) {
    progress.show(static_cast<double>(reader.position()) / static_cast<double>(reader.size()));
    if (!keep(*event)) continue;
    writer.write(event->utime, event->channel, event->recorded);
    ++written;
  }
  writer.close();
  report_damage(input, reader);
  return written;
}

/// The time of the log's first event, robust to a damaged time stamp: the earliest of the first events within a minute
/// of their median.
int64_t begin_of(const std::string& input) {
  LogReader reader(input);
  std::vector<int64_t> times;
  constexpr size_t kFirst = 15;
  for (auto event = reader.next(); event && times.size() < kFirst; event = reader.next()) times.push_back(event->utime);
  std::ranges::sort(times);
  constexpr double kMinute = 60e6;
  const int64_t middle = times[times.size() / 2];
  return *std::ranges::find_if(
      times, [&](int64_t time) { return static_cast<double>(middle) - static_cast<double>(time) < kMinute; });
}

/// Whether a file is what a recorder leaves that was killed before it had written its first event: nothing, or the
/// begin of an event.
bool holds_only_a_begin(const std::string& path) {
  const std::vector<uint8_t> bytes = read_binary_file(path);
  static constexpr std::array<uint8_t, 4> kMark{0xED, 0xA1, 0xDA, 0x01};
  const size_t known = std::min(bytes.size(), kMark.size());
  return std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(known), kMark.begin());
}

/// Nothing for a part of a recording that holds no event, which is said.
std::unique_ptr<LogReader> part_of_recording(const std::string& path) {
  try {
    return std::make_unique<LogReader>(path);
  } catch (const InputError&) {
    if (!std::filesystem::is_regular_file(path) || !holds_only_a_begin(path)) throw;
    std::cerr << "multireach-log: " << path << ": holds no whole event and is left out\n";
    return nullptr;
  }
}

}  // namespace

void report_damage(const std::string& path, const LogReader& reader) {
  if (reader.damaged_places() == 0) return;
  std::cerr << "multireach-log: " << path << ": " << reader.damaged_bytes() << " damaged bytes in "
            << reader.damaged_places() << " places were skipped; `check` lists them\n";
}

void merge_logs(const std::vector<std::string>& inputs, const std::string& output) {
  struct Source {
    std::unique_ptr<LogReader> log;
    std::optional<LogEvent> head;
  };
  std::vector<Source> sources;
  std::vector<std::string> paths;
  for (const std::string& path : inputs) {
    refuse_to_overwrite(path, output);
    auto log = inputs.size() > 1 ? part_of_recording(path) : std::make_unique<LogReader>(path);
    if (!log) continue;
    auto head = log->next();
    sources.push_back({std::move(log), head});
    paths.push_back(path);
  }
  if (sources.empty()) throw InputError(inputs.front() + " and the other logs hold no event of an LCM log");
  LogWriter writer(output);
  while (true) {
    Source* earliest = nullptr;
    for (Source& source : sources) {
      if (source.head && (!earliest || source.head->utime < earliest->head->utime)) earliest = &source;
    }
    if (!earliest) break;
    writer.write(earliest->head->utime, earliest->head->channel, earliest->head->recorded);
    earliest->head = earliest->log->next();
  }
  writer.close();
  for (size_t i = 0; i < paths.size(); ++i) report_damage(paths[i], *sources[i].log);
}

int64_t cut_log(const std::string& input, const std::string& output, double from_s, double until_s) {
  refuse_to_overwrite(input, output);
  const auto first = static_cast<double>(begin_of(input));
  const double from = std::round(from_s * 1e6), until = std::round(until_s * 1e6);
  return copy_if(input, output, [&](const LogEvent& event) {
    const double after = static_cast<double>(event.utime) - first;
    return after >= from && after < until;
  });
}

int64_t filter_log(const std::string& input, const std::string& output, const std::vector<std::string>& patterns,
                   bool without) {
  return copy_if(input, output, [&](const LogEvent& event) {
    const std::string name(event.channel);
    const bool matches = std::ranges::any_of(
        patterns, [&](const std::string& pattern) { return fnmatch(pattern.c_str(), name.c_str(), 0) == 0; });
    return matches != without;
  });
}

}  // namespace multireach
