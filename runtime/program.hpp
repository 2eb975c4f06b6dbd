#pragma once

#include <functional>
#include <string>
#include <vector>

#include "runtime/command_line.hpp"
#include "runtime/live_loop.hpp"

namespace multireach {

/// What all programs share: --help, --version, messages on standard error, and exit codes: 0 success, 1 failure, 2
/// wrong usage or input.
class Program {
 public:
  Program(const std::string& name, const std::string& description);

  CommandLine& cli() { return cli_; }
  /// Adds --lcm-url, --image-url, --key, --key-policy, --speed, --seconds and --lockstep.
  LiveOptions& add_live_options();
  /// Adds --config-reference, which prints the reference page of the configuration files that the program reads.
  void add_config_reference(const std::function<std::string()>& page);
  /// Parses the arguments and runs `body`, whose result is the exit code. An InputError, or a std::invalid_argument
  /// from a stage, is printed as one sentence and gives 2; any other exception, or standard output that cannot be
  /// written, gives 1.
  int run(int argc, char** argv, const std::function<int()>& body);

 private:
  std::string name_;
  CommandLine cli_;
  LiveOptions live_;
};

/// Identifies the source that this program was built from, as in NODE_STATUS and --version.
std::string this_build();

/// Adds --lcm-url (else LCM_DEFAULT_URL of the environment, as in every LCM program), --image-url, --key and
/// --key-policy (else MULTIREACH_KEY and MULTIREACH_KEY_POLICY of the environment).
void add_bus_options(CommandLine& cli, BusOptions& options);

/// The robot.yaml of the Hoap2 that comes with the project, in the source tree or in the installation that this program
/// belongs to. Throws InputError when it is in neither.
std::string default_robot_file();

/// "0.1,-0.2,0.3" as numbers. Throws InputError that names the option.
std::vector<double> parse_numbers(const std::string& option, const std::string& text);

}  // namespace multireach
