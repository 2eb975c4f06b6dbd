#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace multireach {

/// One subcommand: its options, already added to the program, and the function that executes it and returns the exit
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
