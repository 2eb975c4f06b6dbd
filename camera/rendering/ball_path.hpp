#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "runtime/config.hpp"

namespace multireach {

/// The scripted motion of a ball or a tag: it rests, moves smoothly, is thrown, jumps or is invisible.
class BallPath {
 public:
  /// Reads the list `path`. Each entry has `at_s` (not before the previous entry) and one of `position_m` (jump there),
  /// `move_to_m` with `over_s` (a minimum-jerk motion), `throw_to_m` with `over_s` (free fall) or `hidden_for_s`. The
  /// first entry has `position_m` at 0. An entry with a position may have `orientation_wxyz`; one without keeps the
  /// orientation.
  explicit BallPath(const Config& scene);
  /// The section of the reference page on entries of `path`.
  static std::string config_reference();

  /// Position (m, in W) at a time (s from the start).
  Eigen::Vector3d position(double time_s) const;
  /// Rotation from the object's frame to W at a time.
  Eigen::Quaterniond orientation(double time_s) const;
  bool is_invisible(double time_s) const;

 private:
  struct Motion {
    double begin_s, duration_s;
    Eigen::Vector3d to;
    Eigen::Quaterniond R_WT;
    bool falls;
  };
  /// How far a motion is at a time after its begin: 0 to 1.
  static double progress(const Motion& motion, double time_s);
  struct Interval {
    double begin_s, end_s;
  };
  std::vector<Motion> motions_;
  std::vector<Interval> invisible_;
};

}  // namespace multireach
