#pragma once

#include <functional>
#include <optional>

#include "controller/collision/proximity.hpp"
#include "numeric/random.hpp"
#include "runtime/robot_config.hpp"

namespace multireach {

/// Postures near the one in which the arm was at first, well inside the limits, each reached from the last along a
/// straight line of joint space on which the arm's links keep their distance from one another. What stands around the
/// robot is not known.
class SafePostures {
 public:
  static constexpr double kWidth = 0.6;         ///< rad or m: largest distance from the first posture, in each joint
  static constexpr double kShareOfRange = 0.3;  ///< and of the joint's range

  SafePostures(const RobotConfig& robot, const JointVector& first, uint64_t seed);

  /// The next posture, from `from`; nothing when none is found. `wanted` decides which hand poses are of use.
  std::optional<JointVector> next(const JointVector& from, const std::function<bool(const Eigen::Isometry3d&)>& wanted);

 private:
  bool way_is_clear(const JointVector& from, const JointVector& to);

  Chain chain_;
  controller::Proximity proximity_;
  JointVector lower_, upper_;
  CounterRandom random_;
  uint64_t drawn_ = 0;
};

}  // namespace multireach
