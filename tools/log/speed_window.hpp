#pragma once

#include <deque>

#include "kinematics/chain.hpp"

namespace multireach {

/// The largest speed of a stream of joint positions over 20 ms of their times of arrival, as a share of the speed
/// limits.
class SpeedWindow {
 public:
  /// `utime`: time of arrival, microseconds, not before the last.
  void add(const Chain& chain, int64_t utime, const JointVector& position) {
    window_.push_back({utime, position});
    while (window_.size() > 2 && utime - window_[1].utime >= kWindow) window_.pop_front();
    const int64_t duration = utime - window_.front().utime;
    if (duration < kWindow || duration > kGap) return;
    const JointVector moved = (position - window_.front().position).cwiseAbs();
    for (int i = 0; i < chain.size(); ++i)
      largest_ = std::max(largest_, moved[i] * 1e6 / static_cast<double>(duration) / chain.velocity()[i]);
  }
  double largest() const { return largest_; }

 private:
  static constexpr int64_t kWindow = 20000;
  static constexpr int64_t kGap = 500000;  // a longer interruption says nothing about a speed

  struct Timed {
    int64_t utime;
    JointVector position;
  };
  std::deque<Timed> window_;
  double largest_ = 0;
};

}  // namespace multireach
