#pragma once

#include <vector>

#include "studies/figures/motion.hpp"

namespace multireach {

/// A target of a protocol: it is announced at `time_s`, at `position` (m) at that time, and moves with `velocity`
/// (m/s); zero when the protocol does not give the velocity.
struct ProtocolTarget {
  double time_s = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
};

/// The law or controller that moves the arm.
enum class ProtocolLaw {
  kGuarded,             ///< the law `guarded` with default parameters, through ReachController
  kPaper,               ///< the supervised law `paper`, through ReachController
  kPaperLiteral,        ///< Eqs. (19)-(28) as printed; theta_T is searched once, at the first target
  kDampedLeastSquares,  ///< joint velocities by damped least squares; each joint stops at its limits
  kGuardedPose,         ///< like kGuarded, with a prescribed orientation of the hand; for arms of 6 joints or more
};

/// Set-points at 20 Hz: moment k is the set-point for the time k * kProtocolTick seconds; moment 0 is the start.
struct ProtocolRun {
  Motion motion;
  bool finite = true;  // when false, the motion ends at the last finite set-point
};
inline constexpr double kProtocolTick = 0.05;  // s

/// Runs `seconds` of a protocol from rest at `start`. A target takes effect at the first tick at or after its time.
/// `orientation`: the prescribed R_WT of kGuardedPose; other laws ignore it.
ProtocolRun run_protocol(const Chain& chain, ProtocolLaw law, const JointVector& start,
                         const std::vector<ProtocolTarget>& targets, double seconds,
                         const Eigen::Matrix3d& orientation);

}  // namespace multireach
