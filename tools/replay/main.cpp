// multireach-replay: replays recorded sessions to the same bytes, and verifies live runs.
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "runtime/channels.hpp"
#include "runtime/program.hpp"
#include "runtime/progress.hpp"
#include "tools/replay/bisect.hpp"
#include "tools/replay/play.hpp"
#include "tools/replay/request.hpp"
#include "tools/replay/sweep_command.hpp"
#include "tools/replay/verify.hpp"

namespace multireach {
namespace {

std::string hexadecimal(int64_t digest) {
  return fmt::format("{:016x}", static_cast<uint64_t>(digest));
}

/// Messages may hold text that is not valid Unicode; it is replaced.
void write_report(const std::string& path, const nlohmann::ordered_json& report) {
  write_text_file(path, report.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

int run(const RunRequest& request, const std::string& output, const std::string& json) {
  const ReplayOptions options = request.options();
  std::error_code error;
  if (std::filesystem::equivalent(request.session, output, error)) {
    throw InputError(output + ": is the session itself and cannot be written over");
  }
  std::unique_ptr<LogWriter> log;
  if (!output.empty()) log = std::make_unique<LogWriter>(output);
  const int64_t origin =
      Session(options.session, options.from, options.robot == ReplayRobot::kRecorded).recorded_utime();
  Progress progress;
  const auto begin = std::chrono::steady_clock::now();
  const ReplayResult result = replay(
      options,
      [&](int64_t at_us, std::string_view channel, std::span<const uint8_t> bytes, bool) {
        if (log) log->write(origin + at_us, channel, bytes);
      },
      [&](double part) { progress.show(part); });
  if (log) log->close();
  progress.end();
  if (result.damaged_places > 0) {
    std::cerr << fmt::format(
        "multireach-replay: {}: {} damaged bytes in {} {} were skipped; `multireach-log check` lists them\n",
        options.session, result.damaged_bytes, result.damaged_places, result.damaged_places == 1 ? "place" : "places");
  }
  const double took = seconds_since(begin);
  nlohmann::ordered_json report;
  report["session"] = std::filesystem::path(request.session).filename().string();
  report["digest"] = hexadecimal(result.digest);
  report["inputs"] = result.inputs;
  report["span_s"] = result.span_s;
  report["damaged_bytes"] = result.damaged_bytes;
  report["took_s"] = took;
  report["times_real_time"] = result.span_s / took;
  for (const auto& [name, channel] : result.channels) {
    report["channels"][name] = {{"messages", channel.messages}, {"digest", hexadecimal(channel.digest)}};
  }
  if (json != "-") {
    for (const auto& [name, channel] : result.channels) {
      std::cout << fmt::format("{:<18}{:>9}  {}\n", name, channel.messages, hexadecimal(channel.digest));
    }
    std::cout << fmt::format("{:<18}{:>9}  {}\n", "all", "", hexadecimal(result.digest));
    std::cout << fmt::format("{:.2f} s of session in {:.2f} s: {:.0f} times real time\n", result.span_s, took,
                             result.span_s / took);
  }
  if (!json.empty()) write_report(json, report);
  return 0;
}

int play_session(const RunRequest& request, const BusOptions& bus, double speed, bool lockstep) {
  if (!lockstep) {
    throw InputError("play: --lockstep is required; to play a session by the clock, use lcm-logplayer");
  }
  Progress progress;
  const PlayResult result =
      play({.replay = request.options(), .bus = bus, .speed = speed}, [&](double part) { progress.show(part); });
  progress.end();
  if (!result.failure.empty()) {
    std::cerr << "multireach-replay: " << result.failure << "\n";
    return 1;
  }
  std::cout << fmt::format(
      "{} frames, {:.2f} s of session in {:.2f} s: {:.1f} times real time; every node sent the bytes that run gives; "
      "{} messages sent again\n",
      result.frames, result.span_s, result.took_s, result.span_s / result.took_s, result.resent);
  return interrupted() ? 1 : 0;
}

int verify_log(const Setup& setup, const std::string& log, const std::string& json_path) {
  const SplitOverrides set = split(setup.overrides(), true);
  NodeConfigs configs{RobotConfig::load(setup.robot_file(), set.robot), std::nullopt};
  const std::string vision = setup.vision_file(log);
  std::error_code error;
  if (!setup.vision.empty() || std::filesystem::exists(vision, error))
    configs.vision = VisionConfig::load(vision, set.vision);
  Progress progress;
  const Verification result = verify(log, configs, [&](double part) { progress.show(part); });
  progress.end();
  nlohmann::ordered_json report;
  report["holds"] = result.holds();
  std::string table =
      fmt::format("{:<18}{:>10}{:>10}{:>11}{:>13}\n", "channel", "messages", "equal", "different", "not checked");
  for (const auto& [name, channel] : result.channels) {
    report["channels"][name] = {{"messages", channel.messages},
                                {"equal", channel.equal},
                                {"different", channel.different},
                                {"unchecked", channel.unchecked}};
    table += fmt::format("{:<18}{:>10}{:>10}{:>11}{:>13}\n", name, channel.messages, channel.equal, channel.different,
                         channel.unchecked);
  }
  if (const auto& first = result.first) {
    report["first_difference"] = {
        {"channel", first->channel}, {"node", first->node},         {"sequence", first->sequence},
        {"event", first->event},     {"utime", first->utime},       {"after_s", first->after_s},
        {"field", first->field},     {"recorded", first->recorded}, {"computed", first->computed}};
  }
  report["notes"] = result.notes;
  if (json_path != "-") {
    std::cout << table;
    for (const std::string& note : result.notes) std::cout << note << "\n";
    if (result.first) std::cout << "first difference: " << result.first->sentence() << "\n";
  }
  if (!json_path.empty()) write_report(json_path, report);
  if (result.nothing_checked()) {
    std::cerr << "multireach-replay: nothing in " << log << " could be checked\n";
    return 1;
  }
  return result.holds() ? 0 : 1;
}

int bisect_logs(const std::string& old_log, const std::string& new_log, bool common, const std::string& json_path) {
  Progress progress;
  const Comparison result = bisect(old_log, new_log, common, [&](double part) { progress.show(part); });
  progress.end();
  nlohmann::ordered_json report;
  std::string table =
      fmt::format("{:<18}{:>10}{:>11}{:>10}{:>10}\n", "channel", "equal", "different", "only old", "only new");
  report["equal"] = !result.first;
  for (const auto& [name, channel] : result.channels) {
    report["channels"][name] = {{"equal", channel.equal},
                                {"different", channel.different},
                                {"only_old", channel.only_old},
                                {"only_new", channel.only_new}};
    table += fmt::format("{:<18}{:>10}{:>11}{:>10}{:>10}\n", name, channel.equal, channel.different, channel.only_old,
                         channel.only_new);
  }
  if (const auto& first = result.first) {
    report["first_difference"] = {{"channel", first->channel}, {"sequence", first->sequence}, {"field", first->field},
                                  {"old", first->old_value},   {"new", first->new_value},     {"stage", first->node},
                                  {"cause", first->cause}};
    table += fmt::format("first difference: {} {}: {} is {} in the old log and {} in the new\n", first->channel,
                         first->sequence, first->field, first->old_value, first->new_value);
    table += fmt::format("stage: {}: {}\n", first->node.empty() ? "none" : first->node, first->cause);
  }
  if (json_path != "-") std::cout << table;
  if (!json_path.empty()) write_report(json_path, report);
  return result.first ? 1 : 0;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  using namespace multireach;
  cv::setNumThreads(1);
  Program program("multireach-replay", "Recorded sessions computed again to the same bytes, and live runs verified.");
  CommandLine& cli = program.cli();
  cli.require_subcommand();

  RunRequest running;
  std::string output, run_json;
  CommandLine run_command = cli.subcommand(
      "run", "compute vision, controller and bridge from a session's inputs, as fast as the machine can");
  running.add_to(run_command);
  running.setup.add_set_to(run_command);
  running.add_threads_to(run_command);
  run_command.option("-o,--output", output, "log to write: the inputs and everything computed");
  run_command.option("--json", run_json, "where to write counts and digests; - for standard output");

  RunRequest playing;
  double speed = 0;
  bool lockstep = false;
  CommandLine play_command =
      cli.subcommand("play", "play a session to live processes without loss: each frame waits for all processes");
  playing.add_to(play_command);
  playing.add_threads_to(play_command);
  play_command.flag("--lockstep", lockstep, "required: the nodes reset, then follow the session instead of the clock");
  play_command.option("--speed", speed, "seconds of the session per second at most; 0 for no limit")
      .finite(0, 1e6)
      .show_default();
  BusOptions bus;
  add_bus_options(play_command, bus);

  Setup verifying;
  std::string log, verify_json;
  CommandLine verify_command = cli.subcommand(
      "verify",
      "recompute every message of a recorded run from its node's inputs and compare; exit code 1 for a difference");
  verify_command.option("LOG", log, "log of all channels, recorded live or written by run").required();
  verifying.add_to(verify_command);
  verifying.add_set_to(verify_command);
  verify_command.option("--json", verify_json, "where to write the counts; - for standard output");

  std::string old_log, new_log, bisect_json;
  bool common = false;
  CommandLine bisect_command = cli.subcommand(
      "bisect",
      "find the first message and field in which two logs of one session differ, and the stage that sent it; exit "
      "code 1 if they differ");
  bisect_command.option("OLD", old_log, "log written by run, or recorded").required();
  bisect_command.option("NEW", new_log, "another log of the same session").required();
  bisect_command.flag("--common", common, "ignore messages that only one log contains");
  bisect_command.option("--json", bisect_json, "JSON file of the first difference; - for standard output");

  SweepCommand sweeping(cli);

  return program.run(argc, argv, [&] {
    if (sweeping.given()) return sweeping.run();
    if (bisect_command.given()) return bisect_logs(old_log, new_log, common, bisect_json);
    if (play_command.given()) return play_session(playing, bus, speed, lockstep);
    if (verify_command.given()) return verify_log(verifying, log, verify_json);
    return run(running, output, run_json);
  });
}
