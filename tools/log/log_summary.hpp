#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace multireach {

/// What is in a log, channel by channel; memory does not grow with the log.
struct LogSummary {
  struct Channel {
    std::string type = "?";  ///< of the first message; "?" for one that is not the project's
    int64_t events = 0, bytes = 0;
    int64_t first_utime = 0, last_utime = 0;  ///< when the logger received them, microseconds
    int64_t longest_gap_us = 0;
    int64_t malformed = 0;       ///< of a known type, and not one well-formed message of it
    int64_t lost = 0;            ///< gaps in the publisher's sequence numbers
    int64_t restarts = 0;        ///< the publisher's sequence numbers began again
    int64_t next_sequence = -1;  ///< expected
  };
  std::map<std::string, Channel> channels;
  int64_t events = 0, first_utime = 0, last_utime = 0;
  int64_t times_back = 0;       ///< events that the logger dated before the one before, as it does under load
  int64_t numbers_missing = 0;  ///< of the logger's own count of events
  /// Sentences about what is damaged, in the order of the file; the first hundred.
  std::vector<std::string> damage;
  int64_t damaged_places = 0, damaged_bytes = 0;

  bool sound() const;
  nlohmann::json json() const;
  std::string table() const;
};

/// Reads the whole log. Throws InputError when it holds no event at all.
LogSummary summary_of(const std::string& path);

}  // namespace multireach
