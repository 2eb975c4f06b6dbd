#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "runtime/config.hpp"

namespace multireach {

/// Where a ball is at any time: it stays, moves smoothly, jumps and hides as a script says.
class BallPath {
 public:
  /// Reads the list `path`: each entry has `at_s` (not before the one above) and one of `position_m` (be there at
  /// once), `move_to_m` with `over_s` (a minimum-jerk motion) or `hidden_for_s`. The first has `position_m` at 0.
  explicit BallPath(const Config& scene);

  /// Position (m, in W) at a time (s from the start).
  Eigen::Vector3d position(double time_s) const;
  bool hidden(double time_s) const;

 private:
  struct Motion {
    double begin_s, duration_s;
    Eigen::Vector3d to;
  };
  struct Interval {
    double begin_s, end_s;
  };
  std::vector<Motion> motions_;
  std::vector<Interval> hidden_;
};

}  // namespace multireach
