#pragma once

#include <Eigen/Core>

namespace multireach::controller {

/// What is asked of the hand besides its position.
enum class Aim {
  kPosition,  ///< m = 3: nothing
  kPointing,  ///< m = 5: an axis of the tool points in a direction; turning about it is free
  kPose,      ///< m = 6: the whole orientation
};

/// Where the hand shall go.
struct HandTarget {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m, in W
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< m per integration step, in W
  Aim aim = Aim::kPosition;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();       ///< kPointing: unit vector in W
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();  ///< kPose: R_WT
};

/// How a hand target's parts are weighed and which axis of the hand points.
struct Tool {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit vector in T: the axis that points (Aim::kPointing)
  double orientation_length_m = 0.1;                ///< an orientation error of 1 rad counts as this much distance
};

}  // namespace multireach::controller
