// multireach-controller: targets in, joint set-points out.
#include "controller/node/controller_config.hpp"
#include "controller/node/controller_node.hpp"
#include "runtime/program.hpp"

int main(int argc, char** argv) {
  multireach::Program program("multireach-controller",
                              "The reaching controller: TARGET in, JOINT_SETPOINT out at 20 Hz.");
  std::string config;
  program.cli().option("--config", config, "robot.yaml or its folder, as robots/hoap2").required();
  const multireach::LiveOptions& live = program.add_live_options();
  program.add_config_reference(
      [] { return multireach::robot_config_reference() + "\n" + multireach::controller_config_reference(); });
  return program.run(argc, argv, [&] {
    const auto robot = multireach::RobotConfig::load(config);
    return multireach::run_live([&] { return std::make_unique<multireach::ControllerNode>(robot); }, live);
  });
}
