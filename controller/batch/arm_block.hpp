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
  Row theta_target{};                    ///< element of theta_T, rad or m
  std::array<Row, 3> jacobian{};         ///< column of the Jacobian at theta
  std::array<Row, 3> jacobian_target{};  ///< column of the Jacobian at theta_T
};

/// The state, common to all laws, of kRowLanes arms of one kind, each on its own reach. Values used by one step are
/// adjacent in memory.
struct ArmBlock {
  std::array<Row, 3> x{};         ///< hand position K(theta), m, in W
  std::array<Row, 3> x_target{};  ///< K(theta_T)
  std::array<Row, 3> hand_velocity{};
  std::array<Row, 3> target{};                 ///< fixed hand target, m, in W
  Row gamma{};                                 ///< current value, rad^2/m^2
  std::array<JointRows, kMaxJoints> joints{};  ///< the first n are used
};

/// The state of a block under the guarded law.
struct GuardedBlock : ArmBlock {
  GuardedProgress<Row> progress;
};

}  // namespace multireach::controller
