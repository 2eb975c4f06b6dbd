#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace multireach {

/// A summary of a log by channel; its memory does not grow with the log.
struct LogSummary {
  struct Channel {
    std::string type = "?";  ///< of the first message; "?" if unknown
    int64_t events = 0, bytes = 0;
    int64_t first_utime = 0, last_utime = 0;  ///< time of receipt by the logger, microseconds
    int64_t longest_gap_us = 0;
    int64_t malformed = 0;       ///< messages of a known type that are not well-formed
    int64_t lost = 0;            ///< messages missing in the publisher's sequence numbers
    int64_t restarts = 0;        ///< times that the publisher's sequence numbers restarted
    int64_t next_sequence = -1;  ///< next expected sequence number
  };
  std::map<std::string, Channel> channels;
  int64_t events = 0, first_utime = 0, last_utime = 0;
  int64_t times_back = 0;       ///< events with an earlier time than the event before, as loggers write under load
  int64_t numbers_missing = 0;  ///< events missing in the logger's own numbering
  /// Sentences about damaged parts, in file order; the first hundred.
  std::vector<std::string> damage;
  int64_t damaged_places = 0, damaged_bytes = 0;

  bool sound() const;
  nlohmann::json json() const;
  std::string table() const;
};

/// Reads the whole log. Throws InputError when it holds no event.
LogSummary summary_of(const std::string& path);

}  // namespace multireach
