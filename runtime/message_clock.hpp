#pragma once

#include <cstdint>

namespace multireach {

/// The present, microseconds of the monotonic clock. For waiting and for distances in time: never put into a message as
/// it is (see camera/devices/capture_clock.hpp).
int64_t monotonic_us();
/// The present, microseconds since 1970.
int64_t wall_us();

/// Relates the time that messages carry to the monotonic clock: the messages' own delay is taken to be the smallest
/// seen lately, so that jitter in the network does not move the grid of ticks, and a drift between the sender's clock
/// and ours is followed.
class MessageClock {
 public:
  /// `speed`: seconds of message time per second of monotonic time.
  explicit MessageClock(double speed = 1) : speed_(speed) {}

  bool anchored() const { return anchored_; }
  /// Makes `utime` be now.
  void anchor(int64_t utime, int64_t now_us);
  /// A message of time `utime` has arrived at `now_us`. A time that does not fit by more than a second (the first
  /// message, a log that starts again) moves the clock at once.
  void observe(int64_t utime, int64_t now_us);
  /// When it is `utime` on the monotonic clock.
  int64_t monotonic_at(int64_t utime) const {
    return static_cast<int64_t>(static_cast<double>(utime) / speed_) + offset_us_;
  }

 private:
  double speed_;
  bool anchored_ = false;
  int64_t offset_us_ = 0;
  int64_t observed_us_ = 0;
};

}  // namespace multireach
