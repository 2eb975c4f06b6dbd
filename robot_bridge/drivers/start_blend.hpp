#pragma once

#include <algorithm>
#include <cmath>

#include "robot_bridge/motion_limits.hpp"

namespace multireach::drivers {

/// Leads from the arm's standstill to commands that begin at another position: the distance is added to the commands
/// and falls to zero with minimum jerk, each joint within half of its velocity, acceleration and jerk limits.
class StartBlend {
 public:
  /// `distance`: from the first command to the arm. `utime`: of the first command, microseconds.
  StartBlend(const robot_bridge::MotionLimits& limits, const JointVector& distance, int64_t utime)
      : distance_(distance), utime_(utime) {
    for (int i = 0; i < distance.size(); ++i) {
      const double d = std::abs(distance[i]) / kShare;
      // Largest velocity, acceleration and jerk of the quintic from 0 to 1 in unit time: 15/8, 10/sqrt(3) and 60.
      duration_s_ = std::max({duration_s_, 1.875 * d / limits.velocity[i],
                              std::sqrt(5.7735 * d / limits.acceleration[i]), std::cbrt(60 * d / limits.jerk[i])});
    }
  }

  /// Adds what remains at `utime` to a command.
  void apply(int64_t utime, JointVector& position, JointVector& velocity) const {
    if (over(utime)) return;
    const double s = std::max(0.0, static_cast<double>(utime - utime_) * 1e-6 / duration_s_);
    position += (1 - s * s * s * (10 - 15 * s + 6 * s * s)) * distance_;
    velocity -= 30 * s * s * (1 - s) * (1 - s) / duration_s_ * distance_;
  }
  bool over(int64_t utime) const { return static_cast<double>(utime - utime_) * 1e-6 >= duration_s_; }

 private:
  static constexpr double kShare = 0.5;

  JointVector distance_;
  int64_t utime_;
  double duration_s_ = 0;
};

}  // namespace multireach::drivers
