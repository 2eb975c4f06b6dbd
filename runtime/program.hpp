#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "runtime/live_loop.hpp"

namespace multireach {

/// What all programs share: --help, --version, messages on standard error, and exit codes: 0 done, 1 it did not
/// succeed, 2 wrong usage or input.
class Program {
 public:
  Program(const std::string& name, const std::string& description);

  CLI::App& cli() { return app_; }
  /// Adds --lcm-url, --image-url, --speed and --seconds.
  LiveOptions& add_live_options();
  /// Parses the arguments and runs `body`, whose result is the exit code. An InputError, or an std::invalid_argument of
  /// a stage, is printed as one sentence and gives 2; any other exception 1.
  int run(int argc, char** argv, const std::function<int()>& body);

 private:
  std::string name_;
  CLI::App app_;
  LiveOptions live_;
};

/// Which source this program was built from, as NODE_STATUS and --version say it.
std::string this_build();

/// The file of the Hoap2 that comes with the project, in the source tree that this program was built in or beside where
/// it was installed. Throws InputError when it is in neither.
std::string default_robot_file();

/// Refuses what is not a finite number from `min` to `max` (CLI::Range lets NaN pass).
CLI::Validator finite_range(double min, double max);

/// "0.1,-0.2,0.3" as numbers. Throws InputError that names the option.
std::vector<double> parse_numbers(const std::string& option, const std::string& text);

}  // namespace multireach
