#pragma once

#include <vector>

#include "studies/figures/motion.hpp"

namespace multireach {

/// A target as a protocol gives it: known at `time_s`, at `position` then, moving on with `velocity` (m/s) where that
/// is told.
struct ProtocolTarget {
  double time_s = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
};

/// What moves the arm.
enum class ProtocolLaw {
  kGuarded,             ///< the default law at its defaults, through ReachController
  kPaper,               ///< the law `paper` as it lives on a robot, through ReachController
  kPaperLiteral,        ///< Eqs. (19)-(28) as printed, theta_T chosen once, by a search, at the first target
  kDampedLeastSquares,  ///< joint velocities by damped least squares, each joint stopped at its limits
  kGuardedPose,         ///< as kGuarded, with the hand's orientation prescribed; for arms of 6 joints or more
};

/// Set-points at 20 Hz: moment k is where the arm shall be at k * kProtocolTick seconds; moment 0 is the start.
struct ProtocolRun {
  Motion motion;
  bool finite = true;  // when false, the motion ends with the last finite set-point
};
inline constexpr double kProtocolTick = 0.05;  // s

/// Runs `seconds` of a protocol from rest at `start`. A target is taken at the first tick at or after its time.
/// `orientation`: R_WT, what kGuardedPose prescribes.
ProtocolRun run_protocol(const Chain& chain, ProtocolLaw law, const JointVector& start,
                         const std::vector<ProtocolTarget>& targets, double seconds,
                         const Eigen::Matrix3d& orientation);

}  // namespace multireach
