#pragma once

#include <string>
#include <utility>
#include <vector>

#include "runtime/program.hpp"
#include "tools/replay/run.hpp"

namespace multireach {

/// Which robot and which cameras, as in launch.sh, and values that replace some of their files'.
struct Setup {
  std::string config, vision;
  std::vector<std::string> set;  ///< KEY=VALUE

  void add_to(CommandLine& app);
  /// Adds --set for one value of each key.
  void add_set_to(CommandLine& app);
  std::string robot_file() const { return config.empty() ? default_robot_file() : config; }
  std::string vision_file(const std::string& log) const;
  ConfigOverrides overrides() const;
};

/// What replaces values of a robot.yaml, and what of a vision.yaml.
struct SplitOverrides {
  ConfigOverrides robot, vision;
};
/// Throws InputError for a key that is in neither file or that has no effect in a replay.
SplitOverrides split(const ConfigOverrides& overrides, bool simulated_robot);

/// What to replay, and how.
struct RunRequest {
  Setup setup;
  std::string session, robot = "ideal", from = "auto";
  double until_s = 1e9;
  int threads;

  RunRequest();
  /// Adds all options but --set and --threads. Where `session_required` is false, the caller checks for the session.
  void add_to(CommandLine& app, bool session_required = true);
  void add_threads_to(CommandLine& app);
  /// The recorded inputs from which the replay starts; reads the session if they are not given.
  ReplayFrom source() const;
  /// The options with the files' values replaced by `overrides`. Throws InputError.
  ReplayOptions options(ReplayFrom source, const ConfigOverrides& overrides) const;
  ReplayOptions options() const { return options(source(), setup.overrides()); }
};

}  // namespace multireach
