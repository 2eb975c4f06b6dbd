#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/log/sequence_gaps.hpp"

namespace multireach {

/// A summary of a log by channel; its memory does not grow with the log.
struct LogSummary {
  struct Channel {
    std::string type = "?";  ///< of the first message; "?" if unknown
    int64_t events = 0, bytes = 0;
    int64_t first_utime = 0, last_utime = 0;  ///< time of receipt by the logger, microseconds
    int64_t longest_gap_us = 0;
    int64_t malformed = 0;  ///< messages of a known type that are not well-formed
    SequenceGaps sequence;  ///< the publisher's sequence numbers
  };
  std::map<std::string, Channel> channels;
  int64_t events = 0, first_utime = 0, last_utime = 0;
  int64_t times_back = 0;   ///< events with an earlier time than the event before, as loggers write under load
  SequenceGaps numbers{0};  ///< the logger's own numbering of the events
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
