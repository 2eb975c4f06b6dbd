#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "controller/collision/proximity.hpp"
#include "controller/law/guarded_progress.hpp"
#include "controller/law/guarded_settings.hpp"
#include "controller/task/hand_target.hpp"
#include "kinematics/fast_chain.hpp"

namespace multireach::controller {

/// All that the guarded law remembers of one arm between steps. Velocities are per step.
struct GuardedState {
  std::array<double, kMaxJoints> theta{};         ///< joint positions, rad or m
  std::array<double, kMaxJoints> velocity{};      ///< joint velocity
  std::array<double, kMaxJoints> theta_target{};  ///< theta_T
  std::array<double, kMaxJoints> disturbance{};   ///< a displacement to be compensated, rad or m; zero without feedback
  std::array<double, 6> hand_velocity{};  ///< of the hand's task; rotation rows in metres (times orientation_length)
  /// The kinematics at theta (element 0) and theta_T (element 1).
  FastHand<Double2, kMaxJoints> hand;
  bool has_rotation = false;  ///< whether `hand` has rotations
  double gamma = 0;           ///< now, rad^2/m^2
  GuardedProgress<double> progress;
  std::array<double, 3> last_target{};     ///< position of the target in the step before
  std::array<double, 3> awaited{};         ///< position of the target when progress.waited_steps was 0
  std::array<double, 3> checked_target{};  ///< position of the target when theta_T's progress was checked last
  bool slow = false;                       ///< the arm hardly moves although theta_T is elsewhere
  bool target_fixed = false;               ///< theta_T shall stay as it is
  bool obstructed = false;                 ///< a distance to keep changed the velocity in the last step

  std::array<double, 3> position(int configuration) const {
    return {hand.position[0][configuration], hand.position[1][configuration], hand.position[2][configuration]};
  }
};

/// What does not change while an arm moves.
struct GuardedArm {
  FastLinks<0, Double2> links;
  Eigen::Matrix3d tool;  ///< turns the hand's axes into the tool's
  GuardedSettings settings;
};

/// Computes the kinematics of a state whose theta or theta_target was changed from outside.
void update_kinematics(const GuardedArm& arm, GuardedState& state);

/// The schedule of gamma begins anew, for a new target.
void restart_schedule(const GuardedArm& arm, GuardedState& state);

/// One integration step towards the target, with distances to keep. Returns how many linear systems were solved beyond
/// the first.
int guarded_step(const GuardedArm& arm, const HandTarget& target, std::span<const NearPair> pairs, GuardedState& state);

/// After a step: whether theta_T should be searched anew. `target_unchanged`: the target is that of the last search.
bool needs_search(const GuardedArm& arm, const HandTarget& target, bool target_unchanged, GuardedState& state);

}  // namespace multireach::controller
