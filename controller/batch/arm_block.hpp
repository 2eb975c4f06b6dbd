#pragma once

#include <array>

#include "controller/law/guarded_progress.hpp"
#include "kinematics/joint_vector.hpp"
#include "numeric/rows.hpp"

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

/// What the guarded law remembers of a block.
struct GuardedBlock : ArmBlock {
  GuardedProgress<Row> progress;
};

}  // namespace multireach::controller
