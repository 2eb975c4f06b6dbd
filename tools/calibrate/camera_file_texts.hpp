#pragma once

#include <string>
#include <vector>

#include "runtime/camera_files.hpp"

namespace multireach {

/// The contents of the calibration files of this rig: one, or left and right for ROS. Positions in metres. Throws
/// InputError when the format cannot represent the lens: Kalibr's radtan ends at p2. `robot`: include left_to_robot
/// (vision files only).
std::vector<std::string> camera_file_texts(const StereoRig& rig, CameraFormat format, bool robot = false);

/// X_WL in the format of a vision file's section left_to_robot, indented by `indent`.
std::string transform_text(const Eigen::Isometry3d& X, const std::string& indent);

}  // namespace multireach
