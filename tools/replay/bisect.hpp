#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

namespace multireach {

/// What two logs of the same session have in common, and where they part.
struct Comparison {
  struct Channel {
    int64_t equal = 0, different = 0, only_old = 0, only_new = 0;
  };
  std::map<std::string, Channel> channels;
  struct Parting {
    std::string channel, field, old_value, new_value;
    int64_t sequence = -1;
    std::string node;   ///< that sent it; empty for an input of the session
    std::string cause;  ///< a sentence
  };
  /// The first message, in the order of the old log, that is not the same or that the new one has not.
  std::optional<Parting> first;
};

/// Compares the logs of two builds or two configurations message by message, by channels and sequence numbers. With
/// `common_only`, messages that only one log has make no difference. Throws InputError when a log cannot be read.
Comparison bisect(const std::string& old_log, const std::string& new_log, bool common_only,
                  const std::function<void(double)>& progress);

}  // namespace multireach
