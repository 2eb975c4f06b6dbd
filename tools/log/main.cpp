// multireach-log: inspects, checks, edits and exports logs.
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <limits>
#include <optional>

#include "runtime/files.hpp"
#include "runtime/program.hpp"
#include "runtime/progress.hpp"
#include "runtime/rig_config.hpp"
#include "tools/log/export.hpp"
#include "tools/log/import/import.hpp"
#include "tools/log/latency.hpp"
#include "tools/log/log_edit.hpp"
#include "tools/log/log_summary.hpp"
#include "tools/log/run_report.hpp"

namespace multireach {
namespace {

int info(const std::string& log, const std::string& json_path) {
  const LogSummary summary = summary_of(log);
  if (json_path != "-") std::cout << summary.table();
  if (!json_path.empty()) write_json_file(json_path, summary.json());
  return 0;
}

/// Prints a sentence for each problem in the log; returns exit code 1 if there is any.
int check(const std::string& log) {
  const LogSummary summary = summary_of(log);
  const auto say = [&](const std::string& sentence) { std::cout << log << ": " << sentence << "\n"; };
  for (const std::string& sentence : summary.damage) say(sentence);
  if (summary.damaged_places > static_cast<int64_t>(summary.damage.size())) {
    say("and so on: " + std::to_string(summary.damaged_places) + " damaged places");
  }
  if (summary.numbers.lost() > 0) {
    say(std::to_string(summary.numbers.lost()) + " events are missing: gaps in the logger's event numbers");
  }
  if (summary.numbers.damaged() > 0) {
    say(std::to_string(summary.numbers.damaged()) + " events have a number that does not fit: it is damaged");
  }
  for (const auto& [name, channel] : summary.channels) {
    if (channel.malformed > 0) {
      say(name + ": " + std::to_string(channel.malformed) + " messages are no well-formed " + channel.type);
    }
    const int64_t lost = channel.sequence.lost(), damaged = channel.sequence.damaged();
    if (lost > 0) say(name + ": " + std::to_string(lost) + " messages missing (sequence gaps)");
    if (damaged > 0) {
      say(name + ": " + std::to_string(damaged) +
          " messages have a sequence number that does not fit: damaged, or of a second publisher");
    }
  }
  if (summary.sound()) say("sound, " + std::to_string(summary.events) + " events");
  return summary.sound() ? 0 : 1;
}

int report(const std::string& log, const std::string& config, const std::string& json_path) {
  const RunReport result = report_on(log, RobotConfig::load(config));
  std::cerr << table_of(result.json);
  if (!json_path.empty()) write_json_file(json_path, result.json);
  if (!result.succeeded) std::cerr << "multireach-log: " << result.reason << "\n";
  return result.succeeded ? 0 : 1;
}

int latency(const std::string& log, const std::string& json_path) {
  const LatencyReport result = latency_of(log);
  if (json_path != "-") std::cout << result.table();
  if (!json_path.empty()) write_json_file(json_path, result.json());
  if (result.taken_up > 0) return 0;
  std::cerr << "multireach-log: " << log << ": no set-point names a TARGET of this log\n";
  return 1;
}

int written(int64_t events) {
  if (events > 0) {
    std::cerr << events << " events written\n";
    return 0;
  }
  std::cerr << "multireach-log: no event was selected; the output is empty\n";
  return 1;
}

/// The robot and the cameras that a 3-D view draws. Without a vision.yaml, or camera poses in it, it has no cameras.
int export_mcap_with_scene(const std::string& log, const std::string& output, const ChannelPatterns& patterns,
                           const std::string& robot_file, const std::string& vision_file) {
  const RobotConfig robot = RobotConfig::load(robot_file.empty() ? default_robot_file() : robot_file);
  std::string vision = vision_file;
  if (vision.empty()) {
    const auto beside = std::filesystem::path(robot.file.file()).parent_path() / "vision.yaml";
    if (std::filesystem::exists(beside)) vision = beside.string();
  }
  std::optional<RigConfig> rig;
  if (!vision.empty()) rig = load_rig(Config::load(vision).section("cameras"));
  FoxgloveScene scene(robot, rig && rig->has_robot_pose ? &rig->rig : nullptr);
  return written(export_mcap(log, output, patterns, &scene));
}

int export_as(const std::string& format, const std::string& log, const std::string& output,
              const ChannelPatterns& patterns) {
  if (format == "csv") return written(export_csv(log, output, patterns));
  if (format == "mat") return written(export_mat(log, output, patterns));
  if (!patterns.empty()) throw InputError("--channel: " + format + " holds STEREO_IMAGES; expected no --channel");
  std::vector<std::string> warnings;
  const int64_t pairs = format == "pairs"   ? export_pairs(log, output, warnings)
                        : format == "euroc" ? export_euroc(log, output, warnings)
                                            : export_bag(log, output, warnings);
  for (const std::string& warning : warnings) std::cerr << "multireach-log: " << warning << "\n";
  if (pairs == 0) throw InputError(log + ": holds no pair on STEREO_IMAGES");
  std::cerr << pairs << " pairs written\n";
  return warnings.empty() ? 0 : 1;
}

int images(const std::string& log, const std::string& folder, const ChannelPatterns& patterns) {
  std::vector<std::string> warnings;
  const int64_t count = export_images(log, folder, patterns, warnings);
  for (const std::string& warning : warnings) std::cerr << "multireach-log: " << warning << "\n";
  std::cerr << count << " images written\n";
  return count > 0 && warnings.empty() ? 0 : 1;
}

/// Two videos are read by a program of its own: those who import nothing need not install OpenCV's videos.
int import_videos(const std::vector<std::string>& inputs, const ImportOptions& options, const std::string& output) {
  if (!options.left.empty() || !options.right.empty() || options.max_skew_s)
    throw InputError("--left, --right, --max-skew: are not for two videos; expected LEFT RIGHT -o LOG");
  std::error_code error;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = (own.parent_path() / "multireach-videos").string();
  const std::string quality = std::to_string(options.jpeg_quality);
  const std::array<const char*, 8> words{program.c_str(), inputs[0].c_str(), inputs[1].c_str(), "-o",
                                         output.c_str(),  "--jpeg-quality",  quality.c_str(),   nullptr};
  execv(program.c_str(), const_cast<char* const*>(words.data()));
  throw InputError(program + ": " + std::strerror(errno) +
                   "; two videos need this program, of the Debian package multireach-camera");
}

int import_recording(const ImportOptions& options, const std::string& output) {
  std::error_code error;
  if (std::filesystem::equivalent(options.input, output, error))
    throw InputError(output + ": is the recording itself and cannot be written over");
  Progress progress;
  const ImportSummary summary = import_images(options, output, [&](double part) { progress.show(part); });
  progress.end();
  std::cout << summary.text();
  if (!summary.warning.empty()) std::cerr << "multireach-log: " << summary.warning << "\n";
  return 0;
}

}  // namespace
}  // namespace multireach

int main(int argc, char** argv) {
  using namespace multireach;
  Program program("multireach-log", "Inspects, checks, edits and exports lcm-logger logs; reports on runs.");
  CommandLine& cli = program.cli();
  cli.require_subcommand();
  std::vector<std::string> inputs, patterns;
  std::string log, output, config, vision, json;
  double from = 0, until = std::numeric_limits<double>::infinity();
  bool without = false;

  CommandLine informing = cli.subcommand("info", "channels, types, rates, gaps and losses");
  informing.option("LOG", log, "log to read").required();
  informing.option("--json", json, "JSON file to write; - for standard output, instead of the table");

  CommandLine checking =
      cli.subcommand("check", "list damaged, truncated, malformed or lost data; exit code 1 if there is any");
  checking.option("LOG", log, "log to read").required();

  CommandLine cutting = cli.subcommand("cut", "a part of a log");
  cutting.option("LOG", log, "log to read").required();
  cutting.option("-o,--output", output, "log to write").required();
  cutting.option("--from", from, "seconds after the first event").finite(0, 1e9);
  cutting.option("--until", until, "seconds after the first event").finite(0, 1e9);

  CommandLine filtering = cli.subcommand("filter", "some channels of a log");
  filtering.option("LOG", log, "log to read").required();
  filtering.option("-o,--output", output, "log to write").required();
  filtering.option("--channel", patterns, "channels to keep; patterns as 'JOINT_*'").required();
  filtering.flag("--without", without, "leave out the channels of --channel and keep the others");

  CommandLine merging = cli.subcommand("merge", "several logs into one, in the order of time");
  merging.option("LOG", inputs, "logs to merge").required();
  merging.option("-o,--output", output, "log to write").required();

  CommandLine reporting =
      cli.subcommand("report", "report on a run; exit code 1 if a reachable position was missed or a limit exceeded");
  reporting.option("LOG", log, "log of a run, all channels").required();
  reporting.option("--robot", config, "robot.yaml or its folder, as robots/hoap2").required();
  reporting.option("--json", json, "where to write the report; - for standard output");

  CommandLine timing =
      cli.subcommand("latency", "delays from a stereo pair to the first command that follows from it, stage by stage");
  timing.option("LOG", log, "log of a run, all channels").required();
  timing.option("--json", json, "JSON file to write; - for standard output, instead of the table");

  std::string format;
  CommandLine exporting = cli.subcommand("export", "a log in the formats of other tools");
  exporting
      .option("FORMAT", format,
              "csv (a table per channel, in a folder), mcap (JSON with schemas, for Foxglove and Lichtblick), mat "
              "(a struct per channel); the images of a session: pairs (a folder with pairs.csv), euroc (a folder), "
              "or bag (ROS 1)")
      .required()
      .one_of({"csv", "mcap", "mat", "pairs", "euroc", "bag"});
  exporting.option("LOG", log, "log to read").required();
  exporting.option("-o,--output", output, "file to write; for csv, pairs and euroc a folder").required();
  exporting.option("--channel", patterns, "csv, mcap, mat: channels; patterns as 'JOINT_*' (default: all)");

  exporting.option("--robot", config, "mcap: robot.yaml or its folder, drawn in the 3-D view (default: the Hoap2's)");
  exporting.option("--vision", vision, "mcap: vision.yaml, for the cameras (default: beside robot.yaml)");

  CommandLine picturing = cli.subcommand("images", "the images of a log as PNG files");
  picturing.option("LOG", log, "log to read").required();
  picturing.option("-o,--output", output, "folder to write to").required();
  picturing.option("--channel", patterns, "channels; patterns (default: all)");

  ImportOptions recording;
  CommandLine importing = cli.subcommand(
      "import",
      "a session of STEREO_IMAGES from image files, two videos, a bag of ROS 1, or an MCAP file of ROS 2: "
      "docs/import.md");
  importing
      .option("INPUT", inputs, "folder with pairs.csv or of EuRoC, .bag or .mcap file; or two videos, left and right")
      .values(1, 2, "FILE")
      .required();
  importing.option("-o,--output", output, "log to write").required();
  importing.option("--left", recording.left, "topic of the left images; of EuRoC, the camera [cam0]");
  importing.option("--right", recording.right, "topic of the right images; of EuRoC, the camera [cam1]");
  importing
      .option("--max-skew", recording.max_skew_s,
              "largest difference of the two images' times in a pair, s [half a period]")
      .finite(0, 1);
  importing
      .option("--jpeg-quality", recording.jpeg_quality, "JPEG quality of images that are not JPEG; 0 keeps them raw")
      .whole(0, 100)
      .show_default();

  return program.run(argc, argv, [&] {
    if (importing.given()) {
      if (inputs.size() == 2) return import_videos(inputs, recording, output);
      recording.input = inputs[0];
      return import_recording(recording, output);
    }
    if (exporting.given() && format == "mcap") return export_mcap_with_scene(log, output, patterns, config, vision);
    if (exporting.given()) return export_as(format, log, output, patterns);
    if (picturing.given()) return images(log, output, patterns);
    if (informing.given()) return info(log, json);
    if (timing.given()) return latency(log, json);
    if (checking.given()) return check(log);
    if (cutting.given()) return written(cut_log(log, output, from, until));
    if (filtering.given()) return written(filter_log(log, output, patterns, without));
    if (merging.given()) {
      merge_logs(inputs, output);
      return 0;
    }
    return report(log, config, json);
  });
}
