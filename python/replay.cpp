#include <fmt/ranges.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>

#include "python/message_objects.hpp"
#include "runtime/log_file.hpp"
#include "tools/log/run_report.hpp"
#include "tools/replay/request.hpp"

namespace multireach::python {
namespace {

using Path = std::filesystem::path;

/// Throws std::invalid_argument unless the argument is one of the words.
void check_word(const char* argument, const std::string& word, const std::vector<std::string>& words) {
  if (std::ranges::find(words, word) == words.end())
    throw std::invalid_argument(fmt::format("{}: '{}' is not one of {}", argument, word, fmt::join(words, ", ")));
}

std::string hexadecimal(int64_t digest) {
  return fmt::format("{:016x}", static_cast<uint64_t>(digest));
}

py::dict replayed(const Path& session, const Path& robot, const std::optional<Path>& vision,
                  const std::optional<Path>& output, const std::string& robot_model, const std::string& start_with,
                  double until_s, int threads, const std::vector<std::string>& set) {
  check_word("robot_model", robot_model, {"ideal", "sim", "recorded"});
  check_word("start_with", start_with, {"auto", "images", "targets"});
  RunRequest request;  // of multireach-replay run
  request.setup = {robot.string(), vision ? vision->string() : "", set};
  request.session = session.string();
  request.robot = robot_model;
  request.from = start_with;
  request.until_s = until_s;
  request.threads = threads;
  const ReplayOptions options = request.options();
  std::error_code error;
  if (output && std::filesystem::equivalent(session, *output, error))
    throw InputError(output->string() + ": is the session itself and cannot be written over");
  ReplayResult result;
  {
    const py::gil_scoped_release release;
    std::optional<LogWriter> log;
    if (output) log.emplace(output->string());
    const int64_t origin =
        Session(options.session, options.from, options.robot == ReplayRobot::kRecorded).recorded_utime();
    result = replay(
        options,
        [&](int64_t at_us, std::string_view channel, std::span<const uint8_t> bytes, bool) {
          if (log) log->write(origin + at_us, channel, bytes);
        },
        [](double) {});
    if (log) log->close();
  }
  py::dict channels;
  for (const auto& [name, channel] : result.channels)
    channels[py::str(name)] =
        py::dict(py::arg("messages") = channel.messages, py::arg("digest") = hexadecimal(channel.digest));
  return py::dict(py::arg("digest") = hexadecimal(result.digest), py::arg("inputs") = result.inputs,
                  py::arg("span_s") = result.span_s, py::arg("channels") = channels);
}

}  // namespace

void bind_replay(py::module_& module) {
  module.def(
      "replay", &replayed, py::arg("session"), py::arg("robot"), py::arg("vision") = py::none(), py::kw_only(),
      py::arg("output") = py::none(), py::arg("robot_model") = "ideal", py::arg("start_with") = "auto",
      py::arg("until_s") = 1e9, py::arg("threads") = 1, py::arg("set") = std::vector<std::string>{},
      R"(Computes vision, controller and bridge from a session's inputs, in virtual time: the same bytes as multireach-replay run.

session: a recorded log. robot: robot.yaml or its folder. vision: vision.yaml; default: NAME.vision.yaml beside the session
NAME.lcm if there is one, else vision.yaml beside the robot's file. output: a log to write. robot_model: ideal, sim or
recorded. start_with: images, targets or auto. set: values that replace those of the files, as
["controller.gamma_rad2_m2=350"]. Returns {"digest", "inputs", "span_s", "channels": {name: {"messages", "digest"}}}.)");
  module.def(
      "report",
      [](const Path& log, const Path& robot) {
        const RunReport report = report_on(log.string(), RobotConfig::load(robot.string()));
        py::object parsed = py::module_::import("json").attr("loads")(
            report.json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
        return parsed;
      },
      py::arg("log"), py::arg("robot"), "The report on a run, as multireach-log report --json writes it.");
}

}  // namespace multireach::python
