#pragma once

#include <Eigen/Geometry>

#include "imaging/camera_model.hpp"

namespace multireach {

/// Two cameras fixed to each other and to the robot.
struct StereoRig {
  CameraModel left, right;
  Eigen::Isometry3d X_RL;  ///< left camera's frame to right camera's (OpenCV's R and T of a stereo calibration)
  Eigen::Isometry3d X_WL;  ///< left camera's frame to the robot's base

  double baseline_m() const { return X_RL.translation().norm(); }
};

}  // namespace multireach
