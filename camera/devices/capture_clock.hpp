#pragma once

#include "runtime/message_clock.hpp"

namespace multireach {

/// Time stamps for captured images: the monotonic clock, offset to wall time once, at start-up. Intervals between
/// frames therefore stay correct when the wall clock is set, which a tracker would otherwise see as a gap or jump in
/// time.
class CaptureClock {
 public:
  CaptureClock() : offset_us_(wall_us() - monotonic_us()) {}

  int64_t utime_at(int64_t monotonic) const { return monotonic + offset_us_; }
  int64_t now() const { return utime_at(monotonic_us()); }

 private:
  int64_t offset_us_;
};

}  // namespace multireach
