#pragma once

#include <algorithm>
#include <cstdint>

namespace multireach::drivers {

/// Compares the time of the commands with the clock: commands of a simulation that is faster than real time keep their
/// limits in their own time, and would move a real robot as much faster.
class PaceCheck {
 public:
  /// `patience_us`: the arm is stopped without a command for so long, so that the network delays none by more.
  explicit PaceCheck(int64_t patience_us) : most_us_(std::max(patience_us, kLeast)) {}

  /// A command of the nominal time `utime` has arrived at `now_us`. `at_standstill`: it does not move the arm; the
  /// times of the next ones are compared with its. Returns whether it is too far ahead of the clock.
  [[nodiscard]] bool is_ahead(int64_t utime, int64_t now_us, bool at_standstill) {
    const int64_t lead = utime - now_us;
    const int64_t passed = std::max<int64_t>(0, now_us - now_us_);
    if (at_standstill) {
      lead_ = lead;
      counted_ = false;
    } else {
      lead_ += passed / kDrift;
    }
    now_us_ = now_us;
    if (lead <= lead_ + most_us_) return false;
    if (!counted_) times_ = now_us - last_us_ < kSoon ? times_ + 1 : 1;
    if (!counted_) last_us_ = now_us;
    counted_ = true;
    return true;
  }
  /// Whether three motions in a row were: a delay of the network may look like one.
  bool often_ahead() const { return times_ >= 3; }

 private:
  static constexpr int64_t kLeast = 20000;    // us
  static constexpr int64_t kDrift = 500;      // twice the rate by which the bridge's ticks may drift, see MessageClock
  static constexpr int64_t kSoon = 10000000;  // us

  int64_t most_us_;
  int64_t lead_ = 0, now_us_ = 0;
  bool counted_ = false;  // this motion, among ...
  int times_ = 0;         // ... those that were ahead soon after another
  int64_t last_us_ = 0;   // when the last of them was
};

}  // namespace multireach::drivers
