// multireach-log: what is in logs, and logs made from logs.
#include <filesystem>
#include <iostream>
#include <memory>

#include "runtime/files.hpp"
#include "runtime/log_file.hpp"
#include "runtime/program.hpp"
#include "tools/log/run_report.hpp"

namespace multireach {
namespace {

/// Writes the events of several logs into one, in the order of their times (and of the logs, for equal times).
int merge(const std::vector<std::string>& inputs, const std::string& output) {
  struct Source {
    std::unique_ptr<LogReader> log;
    std::optional<LogEvent> head;
  };
  std::vector<Source> sources;
  for (const std::string& path : inputs) {
    std::error_code error;
    if (std::filesystem::equivalent(path, output, error)) {
      throw InputError(output + ": is one of the logs to merge and cannot be written over");
    }
    auto log = std::make_unique<LogReader>(path);
    auto head = log->next();
    sources.push_back({std::move(log), head});
  }
  LogWriter writer(output);
  while (true) {
    Source* earliest = nullptr;
    for (Source& source : sources) {
      if (source.head && (!earliest || source.head->utime < earliest->head->utime)) earliest = &source;
    }
    if (!earliest) break;
    writer.write(earliest->head->utime, earliest->head->channel, earliest->head->data);
    earliest->head = earliest->log->next();
  }
  writer.close();
  return 0;
}

int report(const std::string& log, const std::string& config, const std::string& json_path) {
  const RunReport result = report_on(log, RobotConfig::load(config));
  std::cerr << table_of(result.json);
  if (!json_path.empty()) write_json_file(json_path, result.json);
  if (!result.succeeded) std::cerr << "multireach-log: " << result.reason << "\n";
  return result.succeeded ? 0 : 1;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  using namespace multireach;
  Program program("multireach-log", "Logs of lcm-logger: merged, and reported on.");
  CLI::App& cli = program.cli();
  cli.require_subcommand(1);

  std::vector<std::string> inputs;
  std::string output;
  CLI::App* merging = cli.add_subcommand("merge", "several logs into one, in the order of time");
  merging->add_option("LOG", inputs, "logs to merge")->required();
  merging->add_option("-o,--output", output, "log to write")->required();

  std::string log, config, json;
  CLI::App* reporting = cli.add_subcommand(
      "report", "what happened in a recorded run; exit code 1 when a reachable place was not reached");
  reporting->add_option("LOG", log, "log of a run, all channels")->required();
  reporting->add_option("--config", config, "the robot's file, as robots/hoap2/robot.yaml")->required();
  reporting->add_option("--json", json, "where to write the report; - for standard output");

  return program.run(argc, argv, [&] { return *merging ? merge(inputs, output) : report(log, config, json); });
}
