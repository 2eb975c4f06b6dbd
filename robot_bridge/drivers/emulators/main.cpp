// multireach-robot-emulator: replaces a robot's controller, on the robot's side of its protocol.
#include "robot_bridge/drivers/emulators/emulator_node.hpp"
#include "runtime/message_clock.hpp"
#include "runtime/program.hpp"

int main(int argc, char** argv) {
  using namespace multireach;
  Program program("multireach-robot-emulator", "Emulates a robot's controller, for its driver to talk to.");
  std::string config, name, device;
  program.cli().option("--config", config, "robot.yaml or its folder, as robots/ur5e").required();
  program.cli().option("--driver", name, "the driver it is for; default: driver.name of the robot.yaml");
  program.cli().option(
      "--device", device,
      "path of the emulated serial port, instead of driver.device of the robot.yaml; nothing may exist there");
  LiveOptions& live = program.add_live_options();
  live.real_time = true;
  return program.run(argc, argv, [&] {
    const auto robot = RobotConfig::load(config);
    auto options = drivers::driver_config_from(robot, name);
    if (!device.empty()) options.servo.device = device;
    auto emulator = drivers::make_emulator(robot, options);
    auto transports = drivers::emulator_transports(emulator->links());
    drivers::EmulatorNode node(std::move(emulator), std::move(transports), wall_us);
    return run_live(node, live);
  });
}
