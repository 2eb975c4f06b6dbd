#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "runtime/node.hpp"

namespace multireach {

/// When an image was captured, on the clock of the receiver: the cameras' clock, corrected by the smallest difference
/// between a time of receipt and a time of capture so far. It is late by the shortest delay of a message, so at most by
/// some milliseconds, however long the delays of other messages are. Microseconds.
class CaptureTime {
 public:
  /// A message about images that were captured at `utime`, by the cameras' clock, is received.
  void observe(int64_t utime, int64_t received_us) {
    if (!plausible_utime(utime)) return;
    constexpr int64_t kLongestDelay = 20000000;  // us; more than all queues hold: the cameras' clock was set
    const int64_t difference = received_us - utime;
    if (!difference_ || difference > *difference_ + kLongestDelay) difference_ = difference;
    difference_ = std::min(*difference_, difference);
  }
  /// Nothing before the first message, and for a time that is none.
  std::optional<int64_t> of(int64_t utime) const {
    if (!difference_ || !plausible_utime(utime)) return std::nullopt;
    return utime + *difference_;
  }

 private:
  std::optional<int64_t> difference_;
};

}  // namespace multireach
