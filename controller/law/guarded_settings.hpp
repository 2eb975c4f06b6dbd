#pragma once

#include <array>

#include "controller/law/vite.hpp"
#include "controller/qp/barrier_rate.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

struct GuardedParameters;

/// What the guarded law needs to know of an arm, in its own units: rad (or m), m and integration steps.
struct GuardedSettings {
  ViteGains gains;
  double gamma;                    // rad^2/m^2, the largest value
  BarrierRate barrier_rate{0.04};  // per step, see docs/guarantees.md
  double orientation_length;       // m: an orientation error of 1 rad counts as this much distance
  double reach;                    // m: an upper bound of the distance from the first joint to the hand
  std::array<double, kMaxJoints> lower, upper, speed, acceleration;
};

/// Throws std::invalid_argument for parameters that make no sense; see GuardedLaw.
GuardedSettings guarded_settings(const Chain& chain, const GuardedParameters& parameters);

/// The numbers of the guarded law that are not the user's. Chosen on 2 * 10^5 random reaches of the Hoap2; see
/// docs/guarantees.md for what each is for.
struct GuardedTuning {
  // theta_T
  static constexpr double kSelfMotion = 0.05;         // towards theta, per step
  static constexpr double kLargestTargetStep = 0.05;  // rad or m per step, of any of its joints
  static constexpr double kFarDamping = 2e-3;         // of the square of the reach: its steps while the target is far
  static constexpr double kNearDamping = 4e4;         // of the square of what it lacks, in squares of the reach
  static constexpr double kLeastDamping = 1e-11;      // of the square of the reach
  static constexpr double kDampingRise = 4, kDampingFall = 0.8, kLargestDampingFactor = 1e6;
  static constexpr double kReached = 1e-5;    // m: a hand this near to the target is at it, a tenth of what is promised
  static constexpr int kCheckEvery = 64;      // steps between two looks at its progress
  static constexpr double kNoProgress = 0.7;  // of what it lacked at the last look
  // gamma
  static constexpr double kStalledBelow = 0.2;  // of the speed that the joints' attractor alone would have
  static constexpr double kGammaDecay = 0.98, kGammaRise = 1.02;
  static constexpr double kNearer = 0.98, kPassed = 0.9;
  static constexpr int kIdle = 280, kWait = 700;
  static constexpr double kCeilingDecay = 0.99, kLeastGamma = 1e-9;
  static constexpr double kMovedAway = 0.01;  // of the reach: a target this far off is another one to wait for
  static constexpr double kAtTarget = 1e-3;   // of the reach: here gamma may have its largest value again
  // Another branch
  static constexpr int kQuiet = 140;                         // steps between two searches at least
  static constexpr int kLookAgain = 16;                      // steps between two looks at whether one is needed
  static constexpr double kStrayed = 1.3, kStrayedBy = 0.3;  // further from theta_T than it has been: factor, and rad
};
}  // namespace multireach::controller
