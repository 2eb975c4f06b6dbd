#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace multireach {

/// One subcommand: its options, added to the program's, and what it does when it was chosen, whose result is the exit
/// code.
struct Command {
  CLI::App* app;
  std::function<int()> run;
};

Command cameras_command(CLI::App& cli);
Command colour_command(CLI::App& cli);
Command convert_command(CLI::App& cli);
Command hand_eye_command(CLI::App& cli);

}  // namespace multireach
