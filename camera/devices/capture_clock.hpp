#pragma once

#include "runtime/message_clock.hpp"

namespace multireach {

/// Time stamps for captured images: the monotonic clock, offset to wall time once, at start-up. Intervals between
/// frames therefore stay correct when the wall clock is set, which a tracker would otherwise see as a gap or jump in
/// time.
class CaptureClock {
 public:
  CaptureClock() : offset_us_(wall_us() - monotonic_us()) {}
  /// For a recording, e.g. a video file, which is played from `start_us` of the monotonic clock on: its time begins at
  /// 0, so that a real robot's driver, which compares the time of commands with its own, does not follow it.
  static CaptureClock of_recording(int64_t start_us) { return CaptureClock(-start_us); }

  int64_t utime_at(int64_t monotonic) const { return monotonic + offset_us_; }
  int64_t now() const { return utime_at(monotonic_us()); }

 private:
  explicit CaptureClock(int64_t offset_us) : offset_us_(offset_us) {}

  int64_t offset_us_;
};

}  // namespace multireach
