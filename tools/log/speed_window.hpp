#pragma once

#include <deque>

#include "kinematics/chain.hpp"

namespace multireach {

/// The largest speed of a stream of joint positions over 20 ms, as a share of the speed limits. The time between two
/// positions is the longer one of that between their arrivals at the recorder and that of the robot's clock: a recorder
/// that was late stamps what waited with nearly the same time (lcm-logger by when it read a message), while a stream
/// that is too fast is so by both.
class SpeedWindow {
 public:
  /// `arrival`: at the recorder; `robot_utime`: by the robot's clock, 0 where it is not known. Both in microseconds.
  void add(const Chain& chain, int64_t arrival, int64_t robot_utime, const JointVector& position) {
    const Timed newest{arrival, robot_utime, position};
    window_.push_back(newest);
    while (true) {
      measure(chain, window_.front(), newest);
      if (window_.size() <= 2 || newest.since(window_[1]) < kWindow) return;
      window_.pop_front();
    }
  }
  double largest() const { return largest_; }

 private:
  static constexpr int64_t kWindow = 20000;
  static constexpr int64_t kGap = 500000;  // a longer interruption says nothing about a speed

  struct Timed {
    int64_t arrival, robot_utime;
    JointVector position;

    int64_t since(const Timed& earlier) const {
      const bool by_robot = robot_utime > 0 && earlier.robot_utime > 0;
      return std::max(arrival - earlier.arrival, by_robot ? robot_utime - earlier.robot_utime : 0);
    }
  };

  void measure(const Chain& chain, const Timed& begin, const Timed& end) {
    const int64_t duration = end.since(begin);
    if (duration < kWindow || duration > kGap) return;
    const JointVector moved = (end.position - begin.position).cwiseAbs();
    for (int i = 0; i < chain.size(); ++i)
      largest_ = std::max(largest_, moved[i] * 1e6 / static_cast<double>(duration) / chain.velocity()[i]);
  }

  std::deque<Timed> window_;
  double largest_ = 0;
};

}  // namespace multireach
