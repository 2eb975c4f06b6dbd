#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "controller/collision/proximity.hpp"
#include "controller/law/guarded_progress.hpp"
#include "controller/law/guarded_settings.hpp"
#include "controller/task/task_target.hpp"
#include "kinematics/fast_chain.hpp"

namespace multireach::controller {

/// The state of one arm under the guarded law. Velocities are per step.
struct GuardedState {
  std::array<double, kMaxJoints> theta{};         ///< joint positions, rad or m
  std::array<double, kMaxJoints> velocity{};      ///< joint velocity
  std::array<double, kMaxJoints> theta_target{};  ///< theta_T
  std::array<double, kMaxJoints> disturbance{};   ///< disturbance compensation, rad or m; zero without feedback
  std::array<double, 6> hand_velocity{};  ///< velocity of the hand's task; rotation rows times orientation_length
  /// The kinematics at theta (element 0) and theta_T (element 1).
  FastHand<Double2, kMaxJoints> hand;
  bool has_rotation = false;  ///< whether `hand` has rotations
  double gamma = 0;           ///< current value, rad^2/m^2
  GuardedProgress<double> progress;
  std::array<double, 3> last_target{};     ///< position of the target in the step before
  std::array<double, 3> awaited{};         ///< position of the target when progress.waited_steps was 0
  std::array<double, 3> checked_target{};  ///< position of the target when theta_T's progress was checked last
  bool slow = false;                       ///< the arm hardly moves although it is not at theta_T
  bool target_fixed = false;               ///< theta_T must not change
  bool obstructed = false;                 ///< collision avoidance changed the velocity in the last step

  std::array<double, 3> position(int configuration) const {
    return {hand.position[0][configuration], hand.position[1][configuration], hand.position[2][configuration]};
  }
};

/// The constants of one arm.
struct GuardedArm {
  FastLinks<0, Double2> links;
  Eigen::Matrix3d tool;  ///< rotation of the tool frame in the tip frame T
  GuardedSettings settings;
};

/// Computes state.hand from theta and theta_target. Call it after changing either outside guarded_step().
void update_kinematics(const GuardedArm& arm, GuardedState& state);

/// Restarts the schedule of gamma, for a new target.
void restart_schedule(const GuardedArm& arm, GuardedState& state);

/// One integration step towards the target, with collision avoidance for `pairs`. Returns the number of linear systems
/// solved beyond the first.
int guarded_step(const GuardedArm& arm, const TaskTarget& target, std::span<const ProximityPair> pairs,
                 GuardedState& state);

/// Whether theta_T should be searched again; call it after a step. `target_unchanged`: the target is that of the last
/// search.
bool needs_search(const GuardedArm& arm, const TaskTarget& target, bool target_unchanged, GuardedState& state);

}  // namespace multireach::controller
