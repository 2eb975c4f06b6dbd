#pragma once

#include <Eigen/Geometry>
#include <string>

#include "imaging/stereo_rig.hpp"
#include "runtime/config.hpp"

namespace multireach {

/// One camera: width_px, height_px, fx_px, fy_px, cx_px, cy_px, distortion.
CameraModel camera_model_from(const Config& config);
/// A rigid transform given by `translation_m` and `rpy_rad` or `rotation` (row by row).
Eigen::Isometry3d transform_from(const Config& config);

/// left, right and left_to_right of a section `cameras`; X_WL is the identity.
StereoRig inline_rig(const Config& cameras);

/// The cameras of a vision file.
struct RigConfig {
  StereoRig rig;
  std::string files;  ///< the bytes of the files that the section names, which belong to its digest; "" for none
};

/// Section `cameras` of a vision file. Either left, right, left_to_right, or the calibration's `file` (or `files`, for
/// the two of ROS) with width_px, height_px and unit where the file does not say them; and left_to_robot, which may be
/// {file: F} with F as `multireach-calibrate hand-eye` writes it. Paths are as seen from the vision file. Throws
/// InputError.
RigConfig load_rig(const Config& cameras);

}  // namespace multireach
