#pragma once

#include <Eigen/Core>

namespace multireach::controller {

/// What the target constrains.
enum class TaskKind {
  kPosition,  ///< m = 3: the position only
  kPointing,  ///< m = 5: also the direction of one tool axis; rotation about this axis is free
  kPose,      ///< m = 6: also the whole orientation
};

/// A target of the end effector.
struct TaskTarget {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m, in W
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m per integration step, in W
  TaskKind task = TaskKind::kPosition;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();       ///< kPointing: unit vector in W
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();  ///< kPose: R_WT
};

/// The pointing axis of the tool, and the weight of orientation errors.
struct Tool {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit vector in T: the pointing axis (TaskKind::kPointing)
  double orientation_length_m = 0.1;                ///< an orientation error of 1 rad weighs as much as this distance
};

}  // namespace multireach::controller
