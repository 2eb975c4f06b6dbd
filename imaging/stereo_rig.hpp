#pragma once

#include <Eigen/Geometry>

#include "imaging/camera_model.hpp"

namespace multireach {

/// Two cameras with fixed poses relative to each other and to the robot's base.
struct StereoRig {
  CameraModel left, right;
  Eigen::Isometry3d X_RL;  ///< maps left-camera to right-camera coordinates (R and T of OpenCV's stereo calibration)
  Eigen::Isometry3d X_WL;  ///< maps left-camera coordinates to the robot's base frame W

  double baseline_m() const { return X_RL.translation().norm(); }
};

}  // namespace multireach
