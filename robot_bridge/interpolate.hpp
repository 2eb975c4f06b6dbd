#pragma once

#include <array>
#include <cstdint>

#include "robot_bridge/setpoint.hpp"

namespace multireach::robot_bridge {

/// Linear interpolation between set-points, as on the paper's second computer (Sect. 4). At the time of a set-point
/// plus `delay`, a straight segment starts from the current position to the set-point; it lasts one `period`. The
/// segment of a late set-point starts when the set-point arrives. The position is continuous for any input.
class Interpolator {
 public:
  Interpolator(int64_t period_us, int64_t delay_us) : period_us_(period_us), delay_us_(delay_us) {}

  /// Discards all set-points and holds `theta`.
  void reset(const JointVector& theta);
  /// Adds a set-point. Returns false, and ignores it, when it is not newer than the last.
  bool add(const Setpoint& setpoint);
  /// The position at `utime`, which must not decrease between calls.
  JointVector at(int64_t utime);
  /// Whether, at the last call of `at`, the last segment was complete and no later set-point had started.
  bool holding() const { return holding_; }
  /// Sequence number of the set-point whose segment the last call of `at` followed; -1 for none.
  int64_t sequence() const { return to_.sequence; }

 private:
  void drop_first();

  int64_t period_us_, delay_us_;
  // Set-points whose segment has not started. When more arrive, the oldest is dropped.
  std::array<Setpoint, 4> waiting_;
  size_t num_waiting_ = 0;
  JointVector from_;
  Setpoint to_;
  int64_t begin_us_ = 0, last_us_ = 0;
  bool holding_ = true;
};

}  // namespace multireach::robot_bridge
