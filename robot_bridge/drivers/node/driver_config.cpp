#include "robot_bridge/drivers/node/driver_config.hpp"

#include "robot_bridge/drivers/iiwa_driver.hpp"
#include "robot_bridge/drivers/template_driver.hpp"
#include "runtime/config_keys.hpp"

namespace multireach::drivers {
namespace {

bool is_tcp(const DriverConfig& config) {
  return config.name == "template";
}

ConfigKeys<DriverConfig> driver_keys() {
  ConfigKeys<DriverConfig> keys(
      "robot.yaml, section driver",
      "The driver of a real robot, or of its emulator (`multireach-robot-driver`); docs/robots.md tells of each.");
  keys.choice<std::string>(
          "name", {{"iiwa", "iiwa"}, {"template", "template"}}, [](auto& o) -> auto& { return o.name; },
          "The driver; `--driver` replaces it.")
      .otherwise("none")
      .number(
          "command_timeout_ms", "ms", 5, 1000, [](auto& o) -> auto& { return o.node.command_timeout_us; },
          "Without a JOINT_COMMAND for this long, the driver decelerates the arm. Not longer than the bridge's "
          "`robot_timeout_ms`.",
          1e3)
      .number(
          "max_start_distance", "rad or m", 1e-3, 1, [](auto& o) -> auto& { return o.node.max_start_distance; },
          "Largest distance of the first command from the measured position, in each joint.")
      .only("with a driver for TCP", is_tcp)
      .text(
          "host", [](auto& o) -> auto& { return o.host; }, "Address of the robot.")
      .only("with name: template", [](const DriverConfig& o) { return o.name == "template"; })
      .integer(
          "port", "", 1, 65535, [](auto& o) -> auto& { return o.port; }, "TCP port of the robot.");
  return keys;
}

}  // namespace

DriverConfig driver_config_from(const RobotConfig& robot, const std::string& name) {
  DriverConfig config;
  const auto section = robot.section("driver");
  if (section) {
    config.name = section->has("name") ? section->text("name") : name;
    if (!name.empty() && config.name != name) {
      throw InputError("--driver " + name + ": the section 'driver' of " + robot.file.file() +
                       " is that of the driver '" + config.name + "'");
    }
    driver_keys().read(*section, config);
  }
  if (!name.empty()) config.name = name;
  if (config.name.empty())
    throw InputError(robot.file.file() + ": no driver is named; expected the key 'driver.name', or --driver NAME");
  return config;
}

std::unique_ptr<Driver> make_driver(const RobotConfig& robot, const DriverConfig& config) {
  const int joints = robot.chain.size();
  if (config.name == "iiwa") return std::make_unique<IiwaDriver>(joints);
  if (config.name == "template") return std::make_unique<TemplateDriver>(joints, config.host, config.port);
  throw InputError("--driver: '" + config.name + "' is no driver; expected iiwa or template");
}

std::string driver_config_reference() {
  return driver_keys().reference();
}

}  // namespace multireach::drivers
