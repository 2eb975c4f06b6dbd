// multireach-bridge: set-points in, 1 kHz commands out.
#include <spdlog/spdlog.h>

#include "robot_bridge/node/bridge_node.hpp"
#include "runtime/program.hpp"

int main(int argc, char** argv) {
  multireach::Program program("multireach-bridge", "The robot bridge: JOINT_SETPOINT in, JOINT_COMMAND out at 1 kHz.");
  std::string config;
  program.cli().option("--config", config, "robot.yaml or its folder, as robots/hoap2").required();
  multireach::LiveOptions& live = program.add_live_options();
  live.real_time = true;
  program.add_config_reference(
      [] { return multireach::robot_config_reference() + "\n" + multireach::bridge_config_reference(); });
  return program.run(argc, argv, [&] {
    const auto robot = multireach::RobotConfig::load(config);
    for (const std::string& doubt : multireach::doubts_about(robot)) spdlog::warn("{}: {}", robot.file.file(), doubt);
    return multireach::run_live([&] { return std::make_unique<multireach::BridgeNode>(robot); }, live);
  });
}
