// multireach-view: a live line of the traffic, or waiting until nodes run.
#include <unistd.h>

#include <iostream>

#include "runtime/program.hpp"
#include "tools/view/view_node.hpp"

int main(int argc, char** argv) {
  using namespace multireach;
  Program program("multireach-view", "A live line: target, hand, distance, rates. Or wait until nodes run.");
  std::string config;
  std::vector<std::string> wait_for;
  program.cli().add_option("--config", config, "the robot's file, as robots/hoap2/robot.yaml")->required();
  program.cli()
      .add_option("--wait-for", wait_for,
                  "nodes, with commas between them: end with 0 when all have been heard of, with 1 after --seconds")
      ->delimiter(',');
  const LiveOptions& live = program.add_live_options();
  return program.run(argc, argv, [&] {
    ViewNode node(RobotConfig::load(config),
                  {.wait_for = {wait_for.begin(), wait_for.end()}, .terminal = isatty(STDERR_FILENO) != 0});
    const int result = run_live(node, live);
    for (const std::string& missing : node.missing())
      std::cerr << "multireach-view: " << missing << " was not heard of\n";
    return node.missing().empty() ? result : 1;
  });
}
