#include "runtime/program.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <iostream>

#include "runtime/build_id.hpp"
#include "runtime/channels.hpp"
#include "runtime/files.hpp"

namespace multireach {

Program::Program(const std::string& name, const std::string& description)
    : name_(name), cli_(name, description, name + " " + kVersion + " (build " + kBuildId + ")") {}

void add_bus_options(CommandLine& cli, BusOptions& options) {
  options.control_url = channel::kControlUrl;
  cli.option("--lcm-url", options.control_url, "LCM group of everything but images")
      .environment("LCM_DEFAULT_URL")
      .show_default();
  cli.option("--image-url", options.image_url,
             "LCM group of the images (default: " + std::string(channel::kImageUrl) +
                 ", or one port above another --lcm-url)");
  cli.option("--key", options.key_file,
             "sign messages with the key in this file, and refuse others (default: MULTIREACH_KEY of the environment)")
      .environment("MULTIREACH_KEY");
  cli.option("--key-policy", options.key_policy, "YAML file: which channels are signed (default: all of multireach)")
      .environment("MULTIREACH_KEY_POLICY");
}

LiveOptions& Program::add_live_options() {
  add_bus_options(cli_, live_);
  cli_.option("--speed", live_.speed, "seconds of message time per second").finite(0.01, 100).show_default();
  cli_.option("--seconds", live_.seconds, "end after this many seconds; 0 for never").finite(0, 1e9).show_default();
  cli_.flag("--lockstep", live_.lockstep, "let multireach-replay play --lockstep drive this process");
  return live_;
}

void Program::add_config_reference(const std::function<std::string()>& page) {
  cli_.information("--config-reference", page, "print the reference of the configuration files' keys, and stop");
}

int Program::run(int argc, char** argv, const std::function<int()>& body) {
  auto logger = spdlog::stderr_color_mt(name_);
  logger->set_pattern("[%H:%M:%S.%e] [%n] [%^%l%$] %v");
  spdlog::set_default_logger(logger);
  if (const auto code = cli_.parse(argc, argv)) return *code;
  try {
    const int code = body();
    flush_standard_output();
    return code;
  } catch (const InputError& error) {
    std::cerr << name_ << ": " << error.what() << "\n";
    return 2;
  } catch (const std::invalid_argument& error) {
    std::cerr << name_ << ": " << error.what() << "\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << name_ << ": " << error.what() << "\n";
    return 1;
  }
}

std::string this_build() {
  return kBuildId;
}

std::string default_robot_file() {
  std::error_code error;
  const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  for (const char* path : {"../share/multireach/robots/hoap2/robot.yaml", "../../../robots/hoap2/robot.yaml"}) {
    const auto file = (folder / path).lexically_normal();
    if (std::filesystem::exists(file, error)) return file.string();
  }
  throw InputError("the default robot.yaml (Hoap2) was not found; give --robot");
}

std::vector<double> parse_numbers(const std::string& option, const std::string& text) {
  std::vector<double> values;
  const char* at = text.data();
  const char* end = at + text.size();
  while (at <= end) {
    const char* comma = std::find(at, end, ',');
    while (at < comma && (*at == ' ' || *at == '+')) ++at;
    const char* last = comma;
    while (last > at && last[-1] == ' ') --last;
    double value = 0;
    const auto [stopped, error] = std::from_chars(at, last, value);
    if (error != std::errc() || stopped != last) {
      throw InputError(option + ": '" + std::string(at, last) +
                       "' is not a number; expected numbers with commas between them");
    }
    values.push_back(value);
    at = comma + 1;
  }
  return values;
}

}  // namespace multireach
