#pragma once

#include <array>

#include "controller/ik/ik_options.hpp"
#include "controller/law/step_pace.hpp"
#include "controller/law/vite.hpp"
#include "controller/qp/barrier_rate.hpp"
#include "controller/task/task_target.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

struct GuardedParameters;

/// Parameters of the guarded law for one arm, in the law's units: rad (or m), m and integration steps.
struct GuardedSettings {
  ViteGains gains;  // per step of this rate
  StepPace pace;
  double gamma;                    // rad^2/m^2, largest value
  BarrierRate barrier_rate{0.04};  // per step, see docs/guarantees.md
  double orientation_length;       // m: an orientation error of 1 rad weighs as much as this distance
  double reach;                    // m: an upper bound of the distance from the first joint to the hand
  std::array<double, kMaxJoints> lower, upper, speed,
      acceleration;                         // a locked joint has speed 0 and no position limits
  std::array<double, kMaxJoints> mobility;  // 1 / weight^2; 0 for a locked joint
};

/// The options of the inverse kinematics, with the weights of the law's joints.
IkOptions guarded_ik_options(const Chain& chain, const GuardedParameters& parameters);

/// Throws std::invalid_argument for invalid parameters; see GuardedLaw.
GuardedSettings guarded_settings(const Chain& chain, const GuardedParameters& parameters);

/// Internal constants of the guarded law, tuned on 2 * 10^5 random reaches of the Hoap2; docs/guarantees.md explains
/// them. Those that depend on the integration rate are in StepPace.
struct GuardedTuning {
  // Step of theta_T
  static constexpr double kFarDamping = 2e-3;   // times reach^2: damping while the target is far
  static constexpr double kNearDamping = 4e4;   // damping is kFarDamping * this * residual^2 near the target
  static constexpr double kMinDamping = 1e-11;  // times reach^2: added to the damping
  static constexpr double kMaxDampingFactor = 1e6;
  static constexpr double kReached = 1e-5;    // m: theta_T reaches the target; a tenth of the guaranteed accuracy
  static constexpr double kNoProgress = 0.7;  // stuck when the residual exceeds this fraction of that at the last check
  // Schedule of gamma
  static constexpr double kStalledBelow = 0.2;  // stalled below this fraction of the joints' attractor's speed
  static constexpr double kNearer = 0.98, kPassed = 0.9;
  static constexpr double kMinGamma = 1e-9;
  static constexpr double kMovedAway = 0.01;  // of the reach: a target that moves this far counts as a new one
  static constexpr double kAtTarget = 1e-3;   // of the reach: the schedule of gamma restarts when the hand is within
                                              // this distance of K(theta_T) ...
  static constexpr double kAtPosture = 0.1;   // rad or m: ... and the arm within this distance of theta_T
  // Searching another theta_T
  static constexpr double kStrayed = 1.3, kStrayedBy = 0.3;  // search beyond factor * least distance to theta_T + rad
};
}  // namespace multireach::controller
