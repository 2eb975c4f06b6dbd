#pragma once

#include <Eigen/Geometry>
#include <string>

#include "imaging/stereo_rig.hpp"
#include "runtime/config.hpp"

namespace multireach {

/// One camera: width_px, height_px, fx_px, fy_px, cx_px, cy_px, distortion.
CameraModel camera_model_from(const Config& config);
/// A rigid transform given by `translation_m` and `rpy_rad` (about fixed x, y, z) or `rotation` (row by row).
Eigen::Isometry3d transform_from(const Config& config);

/// Errors of a calibration: focal_length_relative, baseline_relative, rotation_rad, correlation.
RigErrors rig_errors_from(const Config& config);

/// Reads left, right, left_to_right and, where they are known, errors of a section `cameras`; X_WL is the identity.
StereoRig inline_rig(const Config& cameras);

/// The cameras of a vision file.
struct RigConfig {
  StereoRig rig;
  bool has_robot_pose = false;  ///< whether X_WL is known; without it, X_WL is the identity
  std::string files;            ///< content of all files that the section refers to, for the configuration digest
};

/// Reads the section `cameras` of a vision file. It has either left, right and left_to_right, or the calibration's
/// `file` (`files` for the two files of ROS) with width_px, height_px and unit where the file lacks them; and, once it
/// is known, left_to_robot, which may be {file: F} with F as `multireach-calibrate hand-eye` writes it. Paths are
/// relative to the vision file. Throws InputError.
RigConfig load_rig(const Config& cameras);

/// The sections on cameras of the reference page.
std::string rig_config_reference();

}  // namespace multireach
