#include "robot_bridge/drivers/node/driver_config.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "robot_bridge/drivers/dynamixel_driver.hpp"
#include "robot_bridge/drivers/feetech_driver.hpp"
#include "robot_bridge/drivers/iiwa_driver.hpp"
#include "robot_bridge/drivers/panda_driver.hpp"
#include "robot_bridge/drivers/template_driver.hpp"
#include "robot_bridge/drivers/ur_driver.hpp"
#include "runtime/config_keys.hpp"

namespace multireach::drivers {
namespace {

using Make = std::unique_ptr<Driver> (*)(const DriverConfig& config, int joints);

/// A driver: one row here, and its own keys below. An emulator has its row in drivers/emulators/emulator_node.cpp.
struct DriverKind {
  std::string_view name;
  enum class Transport { kLcm, kTcp, kServoBus } transport;
  int joints;  ///< that it moves; 0 for any number
  Make make;
};

const std::array kDrivers{
    DriverKind{"iiwa", DriverKind::Transport::kLcm, 0,
               [](auto&, int joints) -> std::unique_ptr<Driver> { return std::make_unique<IiwaDriver>(joints); }},
    DriverKind{"panda", DriverKind::Transport::kLcm, 0,
               [](auto&, int joints) -> std::unique_ptr<Driver> { return std::make_unique<PandaDriver>(joints); }},
    DriverKind{"ur", DriverKind::Transport::kTcp, 6,
               [](auto& config, int) -> std::unique_ptr<Driver> {
                 UrOptions options = config.ur;
                 options.host = config.host;
                 return std::make_unique<UrDriver>(options);
               }},
    DriverKind{"dynamixel", DriverKind::Transport::kServoBus, 0,
               [](auto& config, int joints) -> std::unique_ptr<Driver> {
                 return std::make_unique<DynamixelDriver>(joints, config.servo);
               }},
    DriverKind{"feetech", DriverKind::Transport::kServoBus, 0,
               [](auto& config, int joints) -> std::unique_ptr<Driver> {
                 return std::make_unique<FeetechDriver>(joints, config.servo);
               }},
    DriverKind{"template", DriverKind::Transport::kTcp, 0, [](auto& config, int joints) -> std::unique_ptr<Driver> {
                 return std::make_unique<TemplateDriver>(joints, config.host, config.port);
               }}};

const DriverKind* kind_of(const std::string& name) {
  const auto found = std::ranges::find(kDrivers, name, &DriverKind::name);
  return found == kDrivers.end() ? nullptr : &*found;
}

bool uses(const DriverConfig& config, DriverKind::Transport transport) {
  const DriverKind* kind = kind_of(config.name);
  return kind && kind->transport == transport;
}
bool is_tcp(const DriverConfig& config) {
  return uses(config, DriverKind::Transport::kTcp);
}
bool is_servo(const DriverConfig& config) {
  return uses(config, DriverKind::Transport::kServoBus);
}

std::vector<std::pair<std::string, std::string>> names_of_drivers() {
  std::vector<std::pair<std::string, std::string>> names;
  for (const DriverKind& kind : kDrivers) names.emplace_back(kind.name, kind.name);
  return names;
}

std::vector<double> numbers_or_none(const Config& config, const std::string& key) {
  return config.numbers(key, -1, std::vector<double>{});
}

/// The keys of the buses of servos.
void add_servo_keys(ConfigKeys<DriverConfig>& keys) {
  const std::string list = "list, one number for each joint";
  keys.only("with name: dynamixel or feetech", is_servo)
      .text(
          "device", [](auto& o) -> auto& { return o.servo.device; }, "Serial port.")
      .integer(
          "baud", "bit/s", 9600, 4000000, [](auto& o) -> auto& { return o.servo.baud; }, "Rate of the bus.")
      .number(
          "period_ms", "ms", 2, 100, [](auto& o) -> auto& { return o.servo.period_us; },
          "From one cycle on the bus (goals, then positions) to the next.", 1e3)
      .other("motor_ids", list, "", "1, 2, 3, ...", "Id of each joint's motor.",
             [](const Config& config, DriverConfig& o) {
               for (const double id : numbers_or_none(config, "motor_ids")) {
                 if (id != std::floor(id) || id < 0 || id > 252)
                   config.fail("motor_ids", "whole numbers from 0 to 252");
                 if (std::ranges::find(o.servo.motor_ids, static_cast<int>(id)) != o.servo.motor_ids.end())
                   config.fail("motor_ids", "another number for each joint");
                 o.servo.motor_ids.push_back(static_cast<int>(id));
               }
             })
      .other("motor_signs", list, "", "1 for each", "1, or -1 for a motor that turns the other way.",
             [](const Config& config, DriverConfig& o) {
               o.servo.signs = numbers_or_none(config, "motor_signs");
               for (const double sign : o.servo.signs) {
                 if (std::abs(sign) != 1) config.fail("motor_signs", "1 or -1 for each joint");
               }
             })
      .other(
          "motor_zeros", list, "steps of 1/4096 turn", "2048 for each", "Position of each motor where its joint is 0.",
          [](const Config& config, DriverConfig& o) { o.servo.zero_steps = numbers_or_none(config, "motor_zeros"); });
}

/// The options with one value for each joint.
ServoOptions servo_options(const RobotConfig& robot, const DriverConfig& config) {
  ServoOptions options = config.servo;
  const auto joints = static_cast<size_t>(robot.chain.size());
  options.lower = robot.chain.lower();
  options.upper = robot.chain.upper();
  for (size_t i = 0; config.servo.motor_ids.empty() && i < joints; ++i)
    options.motor_ids.push_back(static_cast<int>(i) + 1);
  const auto fits = [&](const auto& values) { return values.empty() || values.size() == joints; };
  if (options.motor_ids.size() != joints || !fits(options.signs) || !fits(options.zero_steps))
    throw InputError(robot.file.file() +
                     ": driver.motor_ids, motor_signs and motor_zeros need one number for each of the " +
                     std::to_string(joints) + " joints");
  return options;
}

ConfigKeys<DriverConfig> driver_keys() {
  ConfigKeys<DriverConfig> keys(
      "robot.yaml, section driver",
      "The driver of a real robot, or of its emulator (`multireach-robot-driver`); docs/robots.md tells of each.");
  keys.choice<std::string>(
          "name", names_of_drivers(), [](auto& o) -> auto& { return o.name; }, "The driver; `--driver` replaces it.")
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
      .only("with name: panda", [](const DriverConfig& o) { return o.name == "panda"; })
      .choice<FrankaModel>(
          "model", {{"panda", FrankaModel::kPanda}, {"fr3", FrankaModel::kResearch3}},
          [](auto& o) -> auto& { return o.franka_model; },
          "Whose limits the emulator enforces. `fr3`: Franka Research 3, whose speed limits depend on the position.")
      .only("with name: ur", [](const DriverConfig& o) { return o.name == "ur"; })
      .choice<bool>(
          "series", {{"e", true}, {"cb3", false}}, [](auto& o) -> auto& { return o.ur.e_series; },
          "`e`: e-Series, 500 Hz; `cb3`: CB3, 125 Hz.")
      .number(
          "lookahead_s", "s", 0.03, 0.2, [](auto& o) -> auto& { return o.ur.lookahead_s; },
          "Smoothing of servoj; a longer one is smoother and later.")
      .number(
          "gain", "", 100, 2000, [](auto& o) -> auto& { return o.ur.gain; }, "Gain of servoj.");
  add_servo_keys(keys);
  keys.only("with name: template", [](const DriverConfig& o) { return o.name == "template"; })
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
  if (is_servo(config)) config.servo = servo_options(robot, config);
  if (config.name.empty())
    throw InputError(robot.file.file() + ": no driver is named; expected the key 'driver.name', or --driver NAME");
  if (config.name == "template" && config.port == 0)
    throw InputError(robot.file.file() + ": key 'driver.port' is missing; expected the TCP port of the robot");
  return config;
}

std::unique_ptr<Driver> make_driver(const RobotConfig& robot, const DriverConfig& config) {
  const DriverKind* kind = kind_of(config.name);
  if (!kind) {
    std::string names;
    for (const DriverKind& known : kDrivers) names += (names.empty() ? "" : ", ") + std::string(known.name);
    throw InputError("--driver: '" + config.name + "' is no driver; expected one of " + names);
  }
  const int joints = robot.chain.size();
  if (kind->joints != 0 && joints != kind->joints) {
    throw InputError(robot.file.file() + ": the driver '" + config.name + "' moves " + std::to_string(kind->joints) +
                     " joints, not " + std::to_string(joints));
  }
  return kind->make(config, joints);
}

std::string driver_config_reference() {
  return driver_keys().reference();
}

}  // namespace multireach::drivers
