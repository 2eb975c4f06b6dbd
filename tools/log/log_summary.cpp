#include "tools/log/log_summary.hpp"

#include <algorithm>
#include <array>
#include <cinttypes>
#include <cstdio>

#include "runtime/log_file.hpp"
#include "runtime/message_schema.hpp"
#include "runtime/progress.hpp"

namespace multireach {
namespace {

constexpr size_t kMaxSentences = 100;
// Types whose `sequence` is that of another message, a JOINT_COMMAND or a TARGET: not each of those has one.
constexpr std::array<std::string_view, 2> kSequenceOfOthers{"bridge_state_t", "target_candidates_t"};

void add_event(LogSummary& summary, const LogEvent& event) {
  LogSummary::Channel& channel = summary.channels[std::string(event.channel)];
  const MessageSchema* type = MessageSchemas::project().of(event.data);
  if (channel.events++ == 0) {
    channel.first_utime = event.utime;
    if (type) channel.type = type->name;
  } else {
    channel.longest_gap_us = std::max(channel.longest_gap_us, time_between(channel.last_utime, event.utime));
  }
  channel.last_utime = event.utime;
  channel.bytes += static_cast<int64_t>(event.data.size());
  if (!type) return;
  if (!well_formed(*type, event.data)) {
    ++channel.malformed;
  } else if (std::ranges::find(kSequenceOfOthers, type->name) != kSequenceOfOthers.end()) {
    return;
  } else if (const auto sequence = sequence_of(*type, event.data)) {
    channel.sequence.add(*sequence, event.utime);
  } else if (channel.sequence.started()) {
    channel.sequence.add(-1, event.utime);  // its sign is damaged
  }
}

double seconds_between(int64_t from_utime, int64_t to_utime) {
  return static_cast<double>(time_between(from_utime, to_utime)) * 1e-6;
}

double rate_of(const LogSummary::Channel& channel) {
  const auto span = seconds_between(channel.first_utime, channel.last_utime);
  return span > 0 ? static_cast<double>(channel.events - 1) / span : 0;
}

}  // namespace

LogSummary summary_of(const std::string& path) {
  LogReader log(path);
  LogSummary summary;
  Progress progress;
  for (;;) {
    progress.show(static_cast<double>(log.position()) / static_cast<double>(log.size()));
    const size_t from = log.position(), damaged_before = log.damaged_bytes();
    const auto event = log.next();
    if (const size_t damaged = log.damaged_bytes() - damaged_before; damaged > 0) {
      std::string sentence = "bytes " + std::to_string(from) + " to " + std::to_string(from + damaged - 1);
      sentence += event ? " hold no valid event" : " at the end hold an incomplete event: the log was cut off";
      const int64_t missing = event ? summary.numbers.missing_before(event->number, event->utime) : 0;
      if (missing > 0) sentence += "; " + std::to_string(missing) + " events are missing there";
      if (summary.damage.size() < kMaxSentences) summary.damage.push_back(sentence);
    }
    if (!event) break;
    if (summary.events++ == 0) {
      summary.first_utime = event->utime;
    } else {
      summary.times_back += event->utime < summary.last_utime;
    }
    summary.numbers.add(event->number, event->utime);
    summary.last_utime = event->utime;
    add_event(summary, *event);
  }
  summary.damaged_places = static_cast<int64_t>(log.damaged_places());
  summary.damaged_bytes = static_cast<int64_t>(log.damaged_bytes());
  return summary;
}

bool LogSummary::sound() const {
  const auto has_gaps = [](const SequenceGaps& gaps) { return gaps.lost() > 0 || gaps.damaged() > 0; };
  const auto bad = [&](const auto& entry) { return entry.second.malformed > 0 || has_gaps(entry.second.sequence); };
  return damaged_bytes == 0 && !has_gaps(numbers) && std::ranges::none_of(channels, bad);
}

nlohmann::json LogSummary::json() const {
  nlohmann::json list = nlohmann::json::object();
  for (const auto& [name, channel] : channels) {
    list[name] = {{"type", channel.type},
                  {"events", channel.events},
                  {"bytes", channel.bytes},
                  {"rate_hz", rate_of(channel)},
                  {"longest_gap_ms", static_cast<double>(channel.longest_gap_us) * 1e-3},
                  {"first_utime", channel.first_utime},
                  {"last_utime", channel.last_utime},
                  {"malformed", channel.malformed},
                  {"lost", channel.sequence.lost()},
                  {"damaged_numbers", channel.sequence.damaged()},
                  {"restarts", channel.sequence.restarts()}};
  }
  return {{"events", events},
          {"first_utime", first_utime},
          {"last_utime", last_utime},
          {"span_s", seconds_between(first_utime, last_utime)},
          {"channels", list},
          {"damaged_places", damaged_places},
          {"damaged_bytes", damaged_bytes},
          {"damage", damage},
          {"numbers_missing", numbers.lost()},
          {"numbers_damaged", numbers.damaged()},
          {"times_back", times_back},
          {"sound", sound()}};
}

std::string LogSummary::table() const {
  char line[256];
  std::snprintf(line, sizeof line, "%" PRId64 " events in %.3f s, %zu channels\n%-20s %-20s %9s %9s %9s %11s %6s %9s\n",
                events, seconds_between(first_utime, last_utime), channels.size(), "channel", "type", "events", "Hz",
                "gap (ms)", "bytes", "lost", "malformed");
  std::string text = line;
  for (const auto& [name, channel] : channels) {
    std::snprintf(line, sizeof line, "%-20s %-20s %9" PRId64 " %9.1f %9.1f %11" PRId64 " %6" PRId64 " %9" PRId64 "\n",
                  name.c_str(), channel.type.c_str(), channel.events, rate_of(channel),
                  static_cast<double>(channel.longest_gap_us) * 1e-3, channel.bytes, channel.sequence.lost(),
                  channel.malformed);
    text += line;
  }
  return text;
}

}  // namespace multireach
