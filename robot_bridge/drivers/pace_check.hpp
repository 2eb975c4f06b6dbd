#pragma once

#include <algorithm>
#include <cstdint>

namespace multireach::drivers {

/// Compares the time of the commands with the clock: commands of a simulation that is faster than real time keep their
/// limits in their own time, and would move a robot as much faster.
class PaceCheck {
 public:
  /// A command of the nominal time `utime` has arrived at `now_us`. `at_standstill`: it does not move the arm; the
  /// times of the next ones are compared with its. Returns whether it is too far ahead of the clock.
  [[nodiscard]] bool is_ahead(int64_t utime, int64_t now_us, bool at_standstill) {
    const int64_t lead = utime - now_us;
    const int64_t passed = std::max<int64_t>(0, now_us - now_us_);
    // Never further away than what the network may delay: the arm would have been stopped meanwhile.
    lead_ = at_standstill ? lead : std::min(lead_ + passed / kDrift, lead + kMost);
    now_us_ = now_us;
    return lead > lead_ + kMost;
  }

 private:
  static constexpr int64_t kMost = 20000;  // us
  static constexpr int64_t kDrift =
      500;  // 1 / 2 per mille: twice what the bridge's ticks may drift by, see MessageClock
  int64_t lead_ = 0, now_us_ = 0;
};

}  // namespace multireach::drivers
