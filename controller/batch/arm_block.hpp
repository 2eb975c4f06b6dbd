#pragma once

#include <array>

#include "kinematics/joint_vector.hpp"
#include "kinematics/rows.hpp"

namespace multireach::controller {

/// One joint of kRowLanes arms. Velocities are per step.
struct JointRows {
  Row theta{};  ///< rad or m
  Row velocity{};
  Row theta_target{};                    ///< of theta_T
  std::array<Row, 3> jacobian{};         ///< its column of the Jacobian at theta
  std::array<Row, 3> jacobian_target{};  ///< and at theta_T
};

/// kRowLanes arms of one kind side by side, each on its own reach: what every law moves. What a step uses lies
/// together.
struct ArmBlock {
  std::array<Row, 3> x{};         ///< hand position K(theta), m, in W
  std::array<Row, 3> x_target{};  ///< K(theta_T)
  std::array<Row, 3> hand_velocity{};
  std::array<Row, 3> target{};                 ///< where the hand shall go, m, in W; it rests
  Row gamma{};                                 ///< rad^2/m^2, now
  std::array<JointRows, kMaxJoints> joints{};  ///< the first n are used
};

/// What the guarded law remembers besides; the names are those of GuardedState and GuardedLaw::Parts.
struct GuardedBlock : ArmBlock {
  Row largest_gamma{}, ceiling{};
  Row best_distance{}, stalled_distance{};
  Row idle_steps{}, waited_steps{};  // whole numbers
  Row steps{}, quiet_until{};        // whole numbers
  Row residual{}, watched_residual{}, caution{};
  Row distance_at_choice{};
  Row posture_stuck{}, out_of_reach{};  // 0 or 1
};

}  // namespace multireach::controller
