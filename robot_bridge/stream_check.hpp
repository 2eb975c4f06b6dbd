#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "robot_bridge/motion_limits.hpp"

namespace multireach::robot_bridge {

/// Largest divided differences of a stream of positions, each divided by its limit: 1 is the limit. They are averages
/// of the derivatives, so a motion that keeps its limits keeps them in the differences too.
class StreamCheck {
 public:
  explicit StreamCheck(const MotionLimits& limits) : limits_(limits), lower_(limits.lower), upper_(limits.upper) {}

  /// The next position, `periods` after the last.
  void add(const JointVector& position, int64_t periods = 1) {
    const double step = static_cast<double>(periods) * kPeriod;
    const double two = (step + steps_[0]) / 2, three = (step + steps_[0] + steps_[1]) / 3;
    for (int i = 0; i < position.size(); ++i) {
      const auto joint = static_cast<size_t>(i);
      const double v = (position[i] - last_[joint][0]) / step, a = (v - last_[joint][1]) / two;
      if (count_ >= 1) velocity_ = std::max(velocity_, std::abs(v) / limits_.velocity[i]);
      if (count_ >= 2) acceleration_ = std::max(acceleration_, std::abs(a) / limits_.acceleration[i]);
      if (count_ >= 3) jerk_ = std::max(jerk_, std::abs(a - last_[joint][2]) / three / limits_.jerk[i]);
      excess_ = std::max({excess_, lower_[i] - position[i], position[i] - upper_[i]});
      last_[joint] = {position[i], count_ >= 1 ? v : 0, count_ >= 2 ? a : 0};
    }
    ++count_;
    steps_ = {step, steps_[0]};
  }
  /// The stream begins again: the next positions are not compared with those before.
  void begin() { count_ = 0; }
  /// The stream begins again from rest at `position`: the next positions are compared with it.
  void begin_at_rest(const JointVector& position) {
    count_ = 3;
    steps_ = {kPeriod, kPeriod};
    for (int i = 0; i < position.size(); ++i) last_[static_cast<size_t>(i)] = {position[i], 0, 0};
  }
  /// A stream of its own begins, where the robot stands. From a position beyond a limit it may only come back.
  void begin_at(const JointVector& robot) {
    begin();
    lower_ = limits_.lower.cwiseMin(robot);
    upper_ = limits_.upper.cwiseMax(robot);
  }

  double velocity() const { return velocity_; }
  double acceleration() const { return acceleration_; }
  double jerk() const { return jerk_; }
  double excess() const { return excess_; }  ///< beyond a position limit, rad or m
  bool keeps() const {
    return velocity_ <= 1 + kRounding && acceleration_ <= 1 + kRounding && jerk_ <= 1 + kRounding && excess_ <= 1e-9;
  }

 private:
  static constexpr double kPeriod = 1e-3;
  // Rounding of positions of some radians, 1e-15, divided by the cube of the period is 1e-6 of a jerk of 1000; between
  // two samples a motion may exceed what was checked by as much as its segments allow (see QuinticSegment::keeps).
  static constexpr double kRounding = 1e-4;

  MotionLimits limits_;
  JointVector lower_, upper_;
  std::array<std::array<double, 3>, kMaxJoints> last_{};
  std::array<double, 2> steps_{kPeriod, kPeriod};  // the last, and the one before, s
  int64_t count_ = 0;
  double velocity_ = 0, acceleration_ = 0, jerk_ = 0, excess_ = 0;
};

}  // namespace multireach::robot_bridge
