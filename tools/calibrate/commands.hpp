#pragma once

#include <functional>

#include "runtime/command_line.hpp"

namespace multireach {

/// One subcommand: its options, already added to the program, and the function that executes it and returns the exit
/// code.
struct Command {
  CommandLine app;
  std::function<int()> run;
};

Command cameras_command(CommandLine& cli);
Command colour_command(CommandLine& cli);
Command convert_command(CommandLine& cli);
Command hand_eye_command(CommandLine& cli);
Command tag_command(CommandLine& cli);

}  // namespace multireach
