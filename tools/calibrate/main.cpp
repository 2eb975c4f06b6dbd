// multireach-calibrate: calibrates two cameras from photographs of a chessboard, their pose relative to the robot, and
// an object's colours; converts third-party calibration formats; draws tags to print.
#include <opencv2/core.hpp>

#include "runtime/program.hpp"
#include "tools/calibrate/commands.hpp"

int main(int argc, char** argv) {
  using namespace multireach;
  Program program(
      "multireach-calibrate",
      "Calibrates two cameras from a chessboard, their pose on the robot and an object's colours; converts formats.");
  program.cli().require_subcommand();
  const std::vector<Command> commands{cameras_command(program.cli()), hand_eye_command(program.cli()),
                                      colour_command(program.cli()), convert_command(program.cli()),
                                      tag_command(program.cli())};
  return program.run(argc, argv, [&] {
    cv::setNumThreads(1);  // for identical results on every machine
    for (const Command& command : commands) {
      if (command.app.given()) return command.run();
    }
    return 2;
  });
}
