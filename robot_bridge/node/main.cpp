// multireach-bridge: set-points in, 1 kHz commands out.
#include "robot_bridge/node/bridge_node.hpp"
#include "runtime/program.hpp"

int main(int argc, char** argv) {
  multireach::Program program("multireach-bridge", "The robot bridge: JOINT_SETPOINT in, JOINT_COMMAND out at 1 kHz.");
  std::string config;
  program.cli().add_option("--config", config, "the robot's file, as robots/hoap2/robot.yaml")->required();
  const multireach::LiveOptions& live = program.add_live_options();
  return program.run(argc, argv, [&] {
    const auto robot = multireach::RobotConfig::load(config);
    return multireach::run_live([&] { return std::make_unique<multireach::BridgeNode>(robot); }, live);
  });
}
