#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/log_file.hpp"

namespace multireach {

/// A recorded log by time, channel and sender. Reads the headers of all events once; the messages stay in the file.
/// Several threads may use it.
class LogIndex {
 public:
  /// The events of one sender on one channel, in order.
  struct Series {
    std::string channel;
    std::string name;  ///< of a target or a node; "" for other channels
    std::vector<uint32_t> events;
  };

  /// Throws InputError when the log cannot be read, or has more than four billion events.
  explicit LogIndex(const std::string& path);

  int64_t size() const { return static_cast<int64_t>(messages_.size()); }
  /// Its number is `i`.
  LogEvent event(int64_t i) const;
  /// Time of receipt since the first event, microseconds; it never decreases from event to event.
  int64_t at_us(int64_t i) const { return times_us_.at(static_cast<size_t>(i)); }
  int64_t duration_us() const { return times_us_.back(); }
  /// The last event at or before this time, and not before the first event.
  int64_t event_before(int64_t at_us) const;

  const std::vector<Series>& series() const { return series_; }
  /// The first series of a channel; null when it has none.
  const Series* series_of(std::string_view channel) const;
  /// The newest event of a series up to event `i`; -1 when there is none.
  static int64_t newest(const Series& series, int64_t i);

 private:
  /// In the mapped file, where the channel's name stands before the message.
  struct Message {
    const uint8_t* bytes;
    uint32_t size, channel_size;
  };

  LogReader reader_;
  int64_t begin_us_ = 0;  // the recorder's clock at the first event
  std::vector<Message> messages_;
  std::vector<int64_t> times_us_;
  std::vector<Series> series_;
};

/// The message time of an event, microseconds, for types that begin with the field `utime`; else what the bytes there
/// say. Nothing when it is too short.
std::optional<int64_t> message_utime(const LogEvent& event);

}  // namespace multireach
