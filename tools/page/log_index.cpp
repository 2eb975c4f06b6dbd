#include "tools/page/log_index.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <multireach/node_status_t.hpp>
#include <multireach/target_candidates_t.hpp>
#include <multireach/target_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/message.hpp"
#include "runtime/tagged_message.hpp"

namespace multireach {
namespace {

/// Whether several senders, with names in their messages, may share a channel.
bool has_senders(std::string_view channel) {
  constexpr std::array kNamed{channel::kTarget, channel::kTargetTruth, channel::kTargetCandidates,
                              channel::kNodeStatus};
  return std::ranges::find(kNamed, channel) != kNamed.end();
}

/// Who sent a message of a channel with several senders; nothing where it cannot be read.
std::optional<std::string> sender_of(const LogEvent& event) {
  if (event.channel == channel::kTarget || event.channel == channel::kTargetTruth) {
    if (auto target = decode<target_t>(event.data)) return std::move(target->name);
    return std::nullopt;
  }
  if (event.channel == channel::kTargetCandidates) {
    if (auto several = decode<target_candidates_t>(event.data)) return std::move(several->name);
    return std::nullopt;
  }
  if (event.channel == channel::kNodeStatus) {
    if (auto status = decode<node_status_t>(event.data)) return std::move(status->node);
    return std::nullopt;
  }
  return "";
}

}  // namespace

LogIndex::LogIndex(const std::string& path) : reader_(path) {
  constexpr size_t kMostNames = 1000;  // of senders, so that damage cannot invent any number
  std::map<std::pair<std::string, std::string>, size_t, std::less<>> known;
  std::vector<std::pair<std::string, size_t>> nameless;  // few: a search is faster than the map
  int64_t newest_us = 0;
  while (const auto event = reader_.next()) {
    if (messages_.size() == std::numeric_limits<uint32_t>::max())
      throw InputError(path + ": has more than four billion events; cut it with  multireach-log cut");
    if (messages_.empty()) begin_us_ = event->utime;
    // Unsigned: a damaged time may be any number.
    newest_us = std::max(newest_us,
                         static_cast<int64_t>(static_cast<uint64_t>(event->utime) - static_cast<uint64_t>(begin_us_)));
    const auto number = static_cast<uint32_t>(messages_.size());
    messages_.push_back({event->recorded.data(), static_cast<uint32_t>(event->recorded.size()),
                         static_cast<uint32_t>(event->channel.size())});
    times_us_.push_back(newest_us);
    const auto quick =
        std::ranges::find(nameless, event->channel, [](const auto& each) -> std::string_view { return each.first; });
    if (quick != nameless.end()) {
      series_[quick->second].events.push_back(number);
      continue;
    }
    const auto name = sender_of(*event);
    if (!name) continue;
    const std::pair key(std::string(event->channel), *name);
    auto found = known.find(key);
    if (found == known.end()) {
      if (series_.size() >= kMostNames) continue;
      found = known.emplace(key, series_.size()).first;
      series_.push_back({key.first, *name, {}});
      if (!has_senders(event->channel)) nameless.emplace_back(key.first, found->second);
    }
    series_[found->second].events.push_back(number);
  }
}

LogEvent LogIndex::event(int64_t i) const {
  const Message& message = messages_.at(static_cast<size_t>(i));
  const std::span recorded(message.bytes, message.size);
  const auto* name = reinterpret_cast<const char*>(message.bytes - message.channel_size);
  return {i, begin_us_ + at_us(i), {name, message.channel_size}, without_trailer(recorded), recorded};
}

int64_t LogIndex::event_before(int64_t at_us) const {
  const auto after = std::ranges::upper_bound(times_us_, at_us);
  return std::max<int64_t>(after - times_us_.begin() - 1, 0);
}

const LogIndex::Series* LogIndex::series_of(std::string_view channel) const {
  const auto found = std::ranges::find(series_, channel, &Series::channel);
  return found == series_.end() ? nullptr : &*found;
}

int64_t LogIndex::newest(const Series& series, int64_t i) {
  const auto after = std::ranges::upper_bound(series.events, i, {}, [](uint32_t e) { return int64_t{e}; });
  return after == series.events.begin() ? -1 : int64_t{*std::prev(after)};
}

std::optional<int64_t> message_utime(const LogEvent& event) {
  constexpr size_t kFingerprint = 8, kEnd = 16;
  if (event.data.size() < kEnd) return std::nullopt;
  uint64_t utime = 0;
  for (size_t i = kFingerprint; i < kEnd; ++i) utime = utime << 8 | event.data[i];
  return static_cast<int64_t>(utime);
}

}  // namespace multireach
