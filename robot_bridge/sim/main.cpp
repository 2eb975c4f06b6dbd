// multireach-robot-sim: the robot, simulated by MuJoCo.
#include "robot_bridge/sim/robot_sim_node.hpp"
#include "runtime/program.hpp"

int main(int argc, char** argv) {
  multireach::Program program("multireach-robot-sim",
                              "The robot, simulated: JOINT_COMMAND and PERTURBATION in, ROBOT_STATE out.");
  std::string config;
  program.cli().option("--config", config, "robot.yaml or its folder, as robots/hoap2").required();
  multireach::LiveOptions& live = program.add_live_options();
  live.real_time = true;
  program.add_config_reference(
      [] { return multireach::robot_config_reference() + "\n" + multireach::robot_sim_config_reference(); });
  return program.run(argc, argv, [&] {
    const auto robot = multireach::RobotConfig::load(config);
    return multireach::run_live([&] { return std::make_unique<multireach::RobotSimNode>(robot); }, live);
  });
}
