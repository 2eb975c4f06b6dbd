// multireach-robot-driver: passes the bridge's commands to a real robot.
#include "robot_bridge/drivers/node/driver_config.hpp"
#include "robot_bridge/drivers/node/driver_node.hpp"
#include "runtime/message_clock.hpp"
#include "runtime/program.hpp"

int main(int argc, char** argv) {
  using namespace multireach;
  Program program("multireach-robot-driver", "A real robot's driver: JOINT_COMMAND in, ROBOT_STATE out.");
  std::string config, name;
  bool simulated = false, accept_recorded = false;
  program.cli().option("--config", config, "robot.yaml or its folder, as robots/ur5e").required();
  program.cli().option("--driver", name, "the driver; default: driver.name of the robot.yaml");
  program.cli().flag("--simulated", simulated, "the robot is emulated: it is enabled at once");
  program.cli().flag("--accept-recorded", accept_recorded, "let a real robot follow recorded images");
  LiveOptions& live = program.add_live_options();
  live.real_time = true;
  program.add_config_reference([] { return drivers::driver_config_reference(); });
  return program.run(argc, argv, [&] {
    if (live.speed != 1) throw InputError("--speed: a robot's time cannot be changed; expected 1");
    const auto robot = RobotConfig::load(config);
    auto options = drivers::driver_config_from(robot, name);
    options.node.simulated = simulated;
    options.node.accept_recorded = accept_recorded;
    auto driver = drivers::make_driver(robot, options);
    auto transports = drivers::client_transports(driver->links());
    drivers::DriverNode node(robot, std::move(driver), std::move(transports), options.node, wall_us);
    return run_live(node, live);
  });
}
