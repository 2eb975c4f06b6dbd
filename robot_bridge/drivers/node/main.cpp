// multireach-robot-driver: passes the bridge's commands to a real robot.
#include "robot_bridge/drivers/node/driver_config.hpp"
#include "robot_bridge/drivers/node/driver_node.hpp"
#include "robot_bridge/drivers/node/metered_driver.hpp"
#include "runtime/files.hpp"
#include "runtime/message_clock.hpp"
#include "runtime/program.hpp"

int main(int argc, char** argv) {
  using namespace multireach;
  Program program("multireach-robot-driver", "A real robot's driver: JOINT_COMMAND in, ROBOT_STATE out.");
  std::string config, name, device, wire_report;
  bool simulated = false, accept_recorded = false;
  program.cli().option("--config", config, "robot.yaml or its folder, as robots/ur5e").required();
  program.cli().option("--driver", name, "the driver; default: driver.name of the robot.yaml");
  program.cli().option("--device", device, "serial port, instead of driver.device of the robot.yaml");
  program.cli().flag("--simulated", simulated, "the robot is emulated: it is enabled at once");
  program.cli().flag("--accept-recorded", accept_recorded, "let a real robot follow recorded images");
  program.cli().option(
      "--wire-report", wire_report,
      "write how regularly the robot was commanded, and how late after JOINT_COMMAND, to this file at the end");
  LiveOptions& live = program.add_live_options();
  live.real_time = true;
  program.add_config_reference([] { return drivers::driver_config_reference(); });
  return program.run(argc, argv, [&] {
    if (live.speed != 1) throw InputError("--speed: a robot's time cannot be changed; expected 1");
    const auto robot = RobotConfig::load(config);
    auto options = drivers::driver_config_from(robot, name);
    if (!device.empty()) options.servo.device = device;
    options.node.simulated = simulated;
    options.node.accept_recorded = accept_recorded;
    auto driver = drivers::make_driver(robot, options);
    drivers::MeteredDriver* meter = nullptr;
    if (!wire_report.empty()) {
      auto metered = std::make_unique<drivers::MeteredDriver>(std::move(driver), monotonic_us);
      meter = metered.get();
      driver = std::move(metered);
    }
    auto transports = drivers::client_transports(driver->links());
    drivers::DriverNode node(robot, std::move(driver), std::move(transports), options.node, wall_us);
    const int code = run_live(node, live);
    if (meter) write_text_file(wire_report, meter->report());
    return code;
  });
}
