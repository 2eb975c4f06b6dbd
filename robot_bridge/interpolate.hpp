#pragma once

#include <array>
#include <cstdint>

#include "kinematics/chain.hpp"

namespace multireach::robot_bridge {

struct Setpoint {
  int64_t utime = 0;  ///< nominal time of the controller's tick, microseconds
  int64_t sequence = -1;
  JointVector theta;  ///< rad or m
};

/// Linear interpolation between set-points, as the paper's second computer does (Sect. 4): from the time of a set-point
/// plus `delay` on, a straight line from where the interpolation is to the set-point, `period` long. A set-point that
/// comes later than that starts its line when it comes. Position is continuous for any input.
class Interpolator {
 public:
  Interpolator(int64_t period_us, int64_t delay_us) : period_us_(period_us), delay_us_(delay_us) {}

  /// Forgets all set-points and stays at `theta`.
  void reset(const JointVector& theta);
  /// Set-points come in the order of their times; one that is not newer than the last replaces nothing and is ignored
  /// (returns false).
  bool add(const Setpoint& setpoint);
  /// The position at `utime`, which never goes back.
  JointVector at(int64_t utime);
  /// Whether the last line had ended at the time of the last `at`, with no set-point after it.
  bool holding() const { return holding_; }
  /// The set-point whose line was followed in the last `at`; -1 for none.
  int64_t sequence() const { return to_.sequence; }

 private:
  void drop_first();

  int64_t period_us_, delay_us_;
  // Set-points whose time has not come; a burst larger than this loses its oldest.
  std::array<Setpoint, 4> waiting_;
  size_t num_waiting_ = 0;
  JointVector from_;
  Setpoint to_;
  int64_t begin_us_ = 0, last_us_ = 0;
  bool holding_ = true;
};

}  // namespace multireach::robot_bridge
