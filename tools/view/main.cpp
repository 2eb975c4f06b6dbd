// multireach-view: prints a live status line, waits until nodes run, or saves what vision sees as a picture.
#include <unistd.h>

#include <iostream>

#include "runtime/message_clock.hpp"
#include "runtime/program.hpp"
#include "tools/view/picture_node.hpp"
#include "tools/view/view_node.hpp"

namespace multireach {
namespace {

int keep_picture(const std::string& path, const LiveOptions& live) {
  PictureNode node(path, wall_us());
  const int result = run_live(node, live);
  node.flush();
  if (node.pictures() > 0) return result;
  std::cerr << "multireach-view: no picture received; is vision running, and does it receive images?\n";
  return 1;
}

constexpr int64_t kDrainPeriod = 100000;  // us; a line for people needs no message at once

int watch(const RobotConfig& robot, const std::vector<std::string>& wait_for, LiveOptions live) {
  live.drain_period_us = kDrainPeriod;
  ViewNode node(
      robot,
      {.wait_for = {wait_for.begin(), wait_for.end()}, .terminal = isatty(STDERR_FILENO) != 0, .speed = live.speed});
  const int result = run_live(node, live);
  for (const std::string& missing : node.missing())
    std::cerr << "multireach-view: " << missing << " sent no NODE_STATUS\n";
  return node.missing().empty() ? result : 1;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  using namespace multireach;
  Program program("multireach-view",
                  "Prints a live status line, waits until nodes run, or saves vision's debug picture.");
  std::string config, picture;
  std::vector<std::string> wait_for;
  const CommandOption robot = program.cli().option("--robot", config, "robot.yaml or its folder, as robots/hoap2");
  const CommandOption nodes =
      program.cli()
          .option("--wait-for", wait_for,
                  "comma-separated nodes: exit with 0 when all have sent NODE_STATUS, with 1 after --seconds")
          .comma_separated();
  program.cli()
      .option("--picture", picture,
              "keep vision's newest debug picture in this JPEG file until --seconds or Ctrl-C; exit code 1 if none "
              "arrives")
      .excludes(robot)
      .excludes(nodes);
  const LiveOptions& live = program.add_live_options();
  return program.run(argc, argv, [&] {
    if (!picture.empty()) return keep_picture(picture, live);
    if (config.empty()) throw InputError("--robot is required, or --picture");
    return watch(RobotConfig::load(config), wait_for, live);
  });
}
