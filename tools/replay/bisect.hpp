#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

namespace multireach {

/// How two logs of the same session compare, and where they first differ.
struct Comparison {
  struct Channel {
    int64_t equal = 0, different = 0, only_old = 0, only_new = 0;
  };
  std::map<std::string, Channel> channels;
  struct FirstDifference {
    std::string channel, field, old_value, new_value;
    int64_t sequence = -1;
    std::string node;   ///< sender of the message; empty for an input of the session
    std::string cause;  ///< a sentence: why the messages differ
  };
  /// The first message, in the order of the old log, that differs or is missing in the new log.
  std::optional<FirstDifference> first;
};

/// Compares the logs of two builds or two configurations message by message, matched by channel and sequence number.
/// With `common_only`, messages that only one log contains are ignored. Throws InputError when a log cannot be read.
Comparison bisect(const std::string& old_log, const std::string& new_log, bool common_only,
                  const std::function<void(double)>& progress);

}  // namespace multireach
