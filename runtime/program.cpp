#include "runtime/program.hpp"

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "runtime/build_id.hpp"
#include "runtime/channels.hpp"
#include "runtime/files.hpp"

namespace multireach {

Program::Program(const std::string& name, const std::string& description) : name_(name), app_(description, name) {
  app_.set_version_flag("--version", name + " " + kVersion + " (build " + kBuildId + ")");
  app_.get_formatter()->column_width(34);
}

void add_url_options(CLI::App& app, LiveOptions& urls) {
  urls.control_url = channel::kControlUrl;
  app.add_option("--lcm-url", urls.control_url, "LCM group of everything but images")
      ->envname("LCM_DEFAULT_URL")
      ->capture_default_str();
  app.add_option("--image-url", urls.image_url,
                 "LCM group of the images (default: " + std::string(channel::kImageUrl) +
                     ", or one port above another --lcm-url)");
}

LiveOptions& Program::add_live_options() {
  add_url_options(app_, live_);
  app_.add_option("--speed", live_.speed, "seconds of message time per second")
      ->check(finite_range(0.01, 100))
      ->capture_default_str();
  app_.add_option("--seconds", live_.seconds, "end after this many seconds; 0 for never")
      ->check(finite_range(0, 1e9))
      ->capture_default_str();
  app_.add_flag("--lockstep", live_.lockstep, "let multireach-replay play --lockstep drive this process");
  return live_;
}

void Program::add_config_reference(const std::function<std::string()>& page) {
  const auto print = [page] {
    std::cout << page();
    throw CLI::Success();
  };
  app_.add_flag_callback("--config-reference", print, "print the reference of the configuration files' keys, and stop");
}

int Program::run(int argc, char** argv, const std::function<int()>& body) {
  auto logger = spdlog::stderr_color_mt(name_);
  logger->set_pattern("[%H:%M:%S.%e] [%n] [%^%l%$] %v");
  spdlog::set_default_logger(logger);
  try {
    app_.parse(argc, argv);
  } catch (const CLI::Success& asked) {
    return app_.exit(asked);
  } catch (const CLI::ParseError& error) {
    std::cerr << name_ << ": " << error.what() << "; see " << name_ << " --help\n";
    return 2;
  }
  try {
    return body();
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
  for (const char* place : {"../share/multireach/robots/hoap2/robot.yaml", "../../../robots/hoap2/robot.yaml"}) {
    const auto file = (folder / place).lexically_normal();
    if (std::filesystem::exists(file, error)) return file.string();
  }
  throw InputError("the default robot.yaml (Hoap2) was not found; give --robot");
}

CLI::Validator finite_range(double min, double max) {
  const std::string range = fmt::format("finite number from {} to {}", min, max);
  return CLI::Validator(
      [=](std::string& text) {
        double value = 0;
        const bool number = CLI::detail::lexical_cast(text, value);
        if (number && std::isfinite(value) && value >= min && value <= max) return std::string();
        return "'" + text + "' is not a " + range;
      },
      "FROM " + fmt::format("{} TO {}", min, max));
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
