#pragma once

#include "runtime/message_clock.hpp"

namespace multireach {

/// The clock that captures are stamped with: the monotonic clock, laid once on the wall's. So frames keep their true
/// distances in time when somebody sets the wall clock, which would otherwise look to a tracker like a lost second.
class CaptureClock {
 public:
  CaptureClock() : offset_us_(wall_us() - monotonic_us()) {}

  int64_t utime_at(int64_t monotonic) const { return monotonic + offset_us_; }
  int64_t now() const { return utime_at(monotonic_us()); }

 private:
  int64_t offset_us_;
};

}  // namespace multireach
