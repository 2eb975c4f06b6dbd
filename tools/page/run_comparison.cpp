#include "tools/page/run_comparison.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <multireach/controller_state_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/message.hpp"
#include "runtime/message_schema.hpp"

namespace multireach {
namespace {

/// What is compared, in the order in which it depends on one another.
constexpr std::array kCompared{channel::kTarget,       channel::kJointSetpoint, channel::kControllerState,
                               channel::kJointCommand, channel::kBridgeState,   channel::kRobotState};

struct TimedEvent {
  int64_t utime;
  int64_t event;
};

/// The events of a series by their message time; of several of one time, the first.
std::vector<TimedEvent> by_utime(const LogIndex& log, const LogIndex::Series& series) {
  std::vector<TimedEvent> events;
  events.reserve(series.events.size());
  for (const uint32_t i : series.events) {
    if (const auto utime = message_utime(log.event(i))) events.push_back({*utime, i});
  }
  std::ranges::stable_sort(events, {}, &TimedEvent::utime);
  const auto same_time = [](const TimedEvent& a, const TimedEvent& b) { return a.utime == b.utime; };
  events.erase(std::unique(events.begin(), events.end(), same_time), events.end());
  return events;
}

const LogIndex::Series* same_series(const LogIndex& log, const LogIndex::Series& series) {
  for (const LogIndex::Series& each : log.series()) {
    if (each.channel == series.channel && each.name == series.name) return &each;
  }
  return nullptr;
}

/// Whether a field only counts or identifies messages.
bool is_bookkeeping(std::string_view path) {
  return path.ends_with("sequence") || path.ends_with("run") || path == "tick" || path == "request";
}

struct FieldDifference {
  std::string field, first, second;
};

std::optional<FieldDifference> field_difference(std::span<const uint8_t> first, std::span<const uint8_t> second) {
  if (std::ranges::equal(first, second)) return std::nullopt;
  const MessageSchema* schema = MessageSchemas::project().of(first);
  if (!schema || schema != MessageSchemas::project().of(second)) return FieldDifference{"type", "one", "another"};
  const auto ours = leaves_of(*schema, first), theirs = leaves_of(*schema, second);
  if (!ours || !theirs) return FieldDifference{"message", ours ? "whole" : "damaged", theirs ? "whole" : "damaged"};
  for (size_t i = 0; i < std::min(ours->size(), theirs->size()); ++i) {
    const MessageLeaf &a = (*ours)[i], &b = (*theirs)[i];
    if (is_bookkeeping(a.path)) continue;
    if (a.path != b.path) return FieldDifference{a.path, a.text(), "missing"};
    if (!std::ranges::equal(a.bytes, b.bytes)) return FieldDifference{a.path, a.text(), b.text()};
  }
  return std::nullopt;
}

class Comparer {
 public:
  Comparer(const LogIndex& first, const LogIndex& second, const std::function<void(double)>& progress)
      : first_(first), second_(second), progress_(progress) {
    result_.offset_us = offset_between(first, second);
    for (const LogIndex::Series& series : first.series()) {
      if (std::ranges::find(kCompared, series.channel) != kCompared.end()) most_ += series.events.size();
    }
  }

  RunComparison compare() {
    for (const std::string_view channel : kCompared) {
      for (const LogIndex::Series& series : first_.series()) {
        if (series.channel == channel) compare(series);
      }
    }
    return result_;
  }

 private:
  void compare(const LogIndex::Series& series) {
    const LogIndex::Series* other = same_series(second_, series);
    if (!other) return;
    const auto ours = by_utime(first_, series), theirs = by_utime(second_, *other);
    auto theirs_next = theirs.begin();
    bool differed = false;
    for (const TimedEvent& our : ours) {
      if (++done_ % 1000 == 0) progress_(static_cast<double>(done_) / static_cast<double>(most_));
      theirs_next = std::ranges::lower_bound(theirs_next, theirs.end(), our.utime, {}, &TimedEvent::utime);
      if (theirs_next == theirs.end()) break;
      if (theirs_next->utime != our.utime) continue;
      ++result_.compared;
      const LogEvent a = first_.event(our.event), b = second_.event(theirs_next->event);
      if (series.channel == channel::kControllerState) compare_hands(our.event, a, b);
      if (differed) continue;
      if (const auto difference = field_difference(a.data, b.data)) {
        differed = true;
        note({.channel = series.channel,
              .name = series.name,
              .utime = our.utime,
              .at_us = first_.at_us(our.event),
              .field = difference->field,
              .first = difference->first,
              .second = difference->second});
      }
    }
  }

  /// Of several channels, the one whose message comes first; at the same time, what the others depend on.
  void note(RunDifference difference) {
    if (!result_.first || difference.at_us < result_.first->at_us) result_.first = std::move(difference);
  }

  void compare_hands(int64_t event, const LogEvent& a, const LogEvent& b) {
    const auto ours = decode<controller_state_t>(a.data), theirs = decode<controller_state_t>(b.data);
    if (!ours || !theirs) return;
    double squared = 0;
    for (int i = 0; i < 3; ++i) squared += std::pow(ours->hand_position_m[i] - theirs->hand_position_m[i], 2);
    if (!(std::sqrt(squared) > result_.hand_distance_m)) return;
    result_.hand_distance_m = std::sqrt(squared);
    result_.hand_at_us = first_.at_us(event);
  }

  const LogIndex &first_, &second_;
  const std::function<void(double)>& progress_;
  size_t done_ = 0, most_ = 1;
  RunComparison result_;
};

}  // namespace

int64_t offset_between(const LogIndex& first, const LogIndex& second) {
  for (const std::string_view channel :
       {channel::kTarget, channel::kStereoImages, channel::kJointSetpoint, channel::kControllerState}) {
    const LogIndex::Series *ours = first.series_of(channel), *theirs = second.series_of(channel);
    if (!ours || !theirs) continue;
    const auto a = by_utime(first, *ours), b = by_utime(second, *theirs);
    for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
      if (i->utime == j->utime) return second.at_us(j->event) - first.at_us(i->event);
      ++(i->utime < j->utime ? i : j);
    }
  }
  return 0;
}

RunComparison compare_runs(const LogIndex& first, const LogIndex& second, const std::function<void(double)>& progress) {
  return Comparer(first, second, progress).compare();
}

nlohmann::ordered_json json_of(const RunComparison& comparison) {
  nlohmann::ordered_json json{{"compared", comparison.compared},
                              {"hand_distance_m", comparison.hand_distance_m},
                              {"hand_at_us", comparison.hand_at_us},
                              {"first", nullptr}};
  if (const auto& first = comparison.first) {
    json["first"] = {{"channel", first->channel}, {"name", first->name},   {"utime", first->utime},
                     {"at_us", first->at_us},     {"field", first->field}, {"values", {first->first, first->second}}};
  }
  return json;
}

}  // namespace multireach
