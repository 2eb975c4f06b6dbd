#pragma once

#include <memory>
#include <string>

#include "robot_bridge/drivers/driver.hpp"
#include "robot_bridge/drivers/franka_limits.hpp"
#include "robot_bridge/drivers/node/driver_node.hpp"
#include "robot_bridge/drivers/servo_bus.hpp"
#include "robot_bridge/drivers/ur_driver.hpp"
#include "runtime/robot_config.hpp"

namespace multireach::drivers {

/// The section `driver` of a robot.yaml.
struct DriverConfig {
  std::string name;
  DriverNodeOptions node{};
  std::string host = "127.0.0.1";  ///< of a robot that is reached over TCP
  int port = 0;                    ///< of the driver `template`
  FrankaModel franka_model = FrankaModel::kPanda;
  UrOptions ur{};
  ServoOptions servo{};  ///< of the drivers `dynamixel` and `feetech`; with an id for each joint
};

/// Reads the section; `name`, where it is not empty, replaces the key `name`. Throws InputError, also when no driver is
/// named.
DriverConfig driver_config_from(const RobotConfig& robot, const std::string& name);
/// Throws InputError when the driver cannot move this arm.
std::unique_ptr<Driver> make_driver(const RobotConfig& robot, const DriverConfig& config);
/// The section `driver` of the reference page.
std::string driver_config_reference();

}  // namespace multireach::drivers
