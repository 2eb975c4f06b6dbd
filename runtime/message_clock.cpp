#include "runtime/message_clock.hpp"

#include <algorithm>
#include <chrono>

#include "runtime/time_line.hpp"

namespace multireach {
namespace {

constexpr int64_t kDriftPpm = 1000;  // largest drift of the sender's clock that is followed

}  // namespace

int64_t monotonic_us() {
  using namespace std::chrono;
  return duration_cast<microseconds>(steady_clock::now().time_since_epoch()).count();
}

int64_t wall_us() {
  using namespace std::chrono;
  return duration_cast<microseconds>(system_clock::now().time_since_epoch()).count();
}

void MessageClock::anchor(int64_t utime, int64_t now_us) {
  offset_us_ = now_us - scaled(utime);
  observed_us_ = now_us;
  anchored_ = true;
}

void MessageClock::observe(int64_t utime, int64_t now_us, bool slew) {
  const int64_t late = now_us - monotonic_at(utime);
  if (!anchored_ || on_another_time_line(now_us, monotonic_at(utime))) return anchor(utime, now_us);
  const int64_t drift = (now_us - observed_us_) * kDriftPpm / 1000000;
  offset_us_ += slew ? std::clamp(late, -drift, drift) : std::min(late, drift);
  observed_us_ = now_us;
}

}  // namespace multireach
