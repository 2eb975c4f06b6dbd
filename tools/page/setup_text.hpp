#pragma once

#include <string>

#include "imaging/stereo_rig.hpp"
#include "runtime/robot_config.hpp"

namespace multireach {

/// What the page needs before the first message, as JSON: the URDF, the chain's links, joints and limits (null: none),
/// and, where `rig` is given, both cameras with X_WC, row by row.
std::string setup_text(const RobotConfig& robot, const StereoRig* rig);

}  // namespace multireach
