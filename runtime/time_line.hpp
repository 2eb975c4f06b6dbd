#pragma once

#include <cstdint>
#include <cstdlib>

namespace multireach {

// The one place that decides when message time starts again: a log is played a second time, or another camera, with
// another clock, takes over. Stages are told; they do not decide it.

/// Times that are further apart belong to different time lines, us.
constexpr int64_t kOneTimeLine = 1000000;

/// Whether `utime` belongs to another time line than `expected`, the time that it should be near to.
inline bool on_another_time_line(int64_t utime, int64_t expected) {
  return std::abs(utime - expected) > kOneTimeLine;
}

/// Whether a stream whose newest time is `newest` starts again at `utime`. Gaps forwards belong to the same time line.
constexpr bool starts_again(int64_t utime, int64_t newest) {
  return utime < newest - kOneTimeLine;
}

}  // namespace multireach
