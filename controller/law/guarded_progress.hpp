#pragma once

#include <limits>

namespace multireach::controller {

/// What the guarded law remembers of a reach besides positions and velocities. `Number` is double for one arm, or a Row
/// of the arms of a block. Whole numbers and truth values (0 or 1) are numbers too, as lanes have them. `residual` is
/// infinite and the flags are 0 when an arm starts.
template <class Number>
struct GuardedProgress {
  Number gamma_max{};           ///< largest value of gamma for this reach, rad^2/m^2
  Number gamma_ceiling{};       ///< what gamma may rise to now
  Number best_distance{};       ///< the least |theta_T - theta| since the target was new, in steps of some per cent
  Number stalled_distance{};    ///< that at which the arm stalled last
  Number idle_steps{};          ///< since best_distance fell
  Number waited_steps{};        ///< since the target was new, or has moved away from where waiting began
  Number residual{};            ///< |target - hand at theta_T|, m
  Number damping_factor{};      ///< of theta_T's steps, at least 1
  Number checked_residual{};    ///< residual when theta_T's progress was checked last
  Number steps_to_check{};      ///< until it is checked again
  Number stuck{};               ///< flag: theta_T has stopped short of the target
  Number steps{};               ///< since the arm started
  Number no_search_before{};    ///< the value of `steps` until which theta_T is not searched again
  Number distance_at_choice{};  ///< |theta_T - theta| when theta_T was chosen, or the least since
  Number unreachable{};         ///< flag: the last search found no configuration that meets the target
};

}  // namespace multireach::controller
