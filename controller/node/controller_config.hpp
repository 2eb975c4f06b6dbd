#pragma once

#include <optional>
#include <string>

#include "controller/reach_controller.hpp"
#include "runtime/robot_config.hpp"

namespace multireach {

/// Reads the section `controller`; all keys have defaults. Throws InputError.
controller::ReachOptions reach_options_from(const RobotConfig& robot);
/// The configured name of the target to reach for; nothing: the first that is seen. Throws InputError.
std::optional<std::string> target_name_from(const RobotConfig& robot);
/// The section `controller` of the reference page.
std::string controller_config_reference();

}  // namespace multireach
