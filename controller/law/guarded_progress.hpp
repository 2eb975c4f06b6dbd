#pragma once

#include <limits>

namespace multireach::controller {

/// State of the guarded law during a reach, besides positions and velocities. `Number` is double for one arm, or a Row
/// for the arms of a block. Counters and flags (0 or 1) are also of type `Number`, because SIMD lanes hold only
/// doubles. When an arm starts, `residual` is infinite and the flags are 0.
template <class Number>
struct GuardedProgress {
  Number gamma_max{};           ///< largest value of gamma for this reach, rad^2/m^2
  Number gamma_ceiling{};       ///< current upper bound of gamma
  Number best_distance{};       ///< least |theta_T - theta| for this target; updated when clearly smaller (kNearer)
  Number stalled_distance{};    ///< least |theta_T - theta| at which the arm has stalled
  Number idle_steps{};          ///< steps since best_distance decreased
  Number waited_steps{};        ///< steps since the target was set, or since it moved away
  Number residual{};            ///< task error of theta_T, m
  Number damping_factor{};      ///< factor of the damping of theta_T's step, at least 1
  Number checked_residual{};    ///< residual at the last check of theta_T's progress
  Number steps_to_check{};      ///< steps until the next check
  Number stuck{};               ///< flag: theta_T has stopped short of the target
  Number steps{};               ///< steps since the arm started
  Number no_search_before{};    ///< value of `steps` before which theta_T is not searched again
  Number distance_at_choice{};  ///< |theta_T - theta| when theta_T was chosen, or the least since
  Number unreachable{};         ///< flag: the last search found no IK solution of the target
};

}  // namespace multireach::controller
