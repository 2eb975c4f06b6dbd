#pragma once

#include <algorithm>
#include <cstdint>

namespace multireach {

/// Current time of the monotonic clock, microseconds. Use it for waiting and for time differences, never directly in a
/// message (see camera/devices/capture_clock.hpp).
int64_t monotonic_us();
/// Current wall time, microseconds since 1970.
int64_t wall_us();

/// Maps message time to the monotonic clock. The offset follows the smallest recent message delay, so that network
/// jitter does not shift the tick times, and drift between the sender's clock and the local clock is followed.
class MessageClock {
 public:
  /// `speed`: seconds of message time per second of monotonic time.
  explicit MessageClock(double speed = 1) : speed_(speed) {}

  bool anchored() const { return anchored_; }
  /// Sets the offset so that message time `utime` corresponds to `now_us`.
  void anchor(int64_t utime, int64_t now_us);
  /// A message of time `utime` has arrived at `now_us`. A deviation of more than a second (the first message, a log
  /// that starts again) resets the offset at once.
  /// `slew`: the time never steps but by such a reset, since a step would skip ticks.
  void observe(int64_t utime, int64_t now_us, bool slew = false);
  /// The monotonic time that corresponds to message time `utime`.
  int64_t monotonic_at(int64_t utime) const { return scaled(utime) + offset_us_; }

 private:
  /// Bounded, so that no time of a message overflows.
  int64_t scaled(int64_t utime) const {
    constexpr double kMost = 1e18;
    return static_cast<int64_t>(std::clamp(static_cast<double>(utime) / speed_, -kMost, kMost));
  }

  double speed_;
  bool anchored_ = false;
  int64_t offset_us_ = 0;
  int64_t observed_us_ = 0;
};

}  // namespace multireach
