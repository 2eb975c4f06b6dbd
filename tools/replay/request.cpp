#include "tools/replay/request.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <thread>

namespace multireach {
namespace {

constexpr std::array<std::string_view, 6> kRobotKeys{"robot",  "tick_ms",   "state_hz", "start_joint_position",
                                                     "bridge", "controller"};
constexpr std::array<std::string_view, 4> kVisionKeys{"cameras", "colour", "tracker", "targets"};

}  // namespace

void Setup::add_to(CommandLine& app) {
  app.option("--robot", config, "robot.yaml or its folder, as robots/hoap2 (default: the Hoap2's)");
  app.option("--vision", vision,
             "cameras and colour (default: LOG.vision.yaml beside LOG.lcm if there is one, else vision.yaml beside "
             "the robot's file)");
}

void Setup::add_set_to(CommandLine& app) {
  app.option("--set", set, "KEY=VALUE: a value instead of the one in robot.yaml or vision.yaml; may be repeated")
      .repeated();
}

std::string Setup::vision_file(const std::string& log) const {
  if (!vision.empty()) return vision;
  const std::string own = std::filesystem::path(log).replace_extension(".vision.yaml").string();
  std::error_code error;
  if (std::filesystem::exists(own, error)) return own;
  const std::string robot = robot_file();  // or its folder
  return std::filesystem::is_directory(robot, error) ? (std::filesystem::path(robot) / "vision.yaml").string()
                                                     : resolve_relative(robot, "vision.yaml");
}

ConfigOverrides Setup::overrides() const {
  ConfigOverrides overrides;
  for (const std::string& text : set) overrides.push_back(config_override_from("--set", text));
  return overrides;
}

SplitOverrides split(const ConfigOverrides& overrides, bool simulated_robot) {
  SplitOverrides parts;
  for (const ConfigOverride& given : overrides) {
    const std::string section = given.key.substr(0, given.key.find_first_of(".["));
    if (section == "robot_sim" && !simulated_robot)
      throw InputError("--set: '" + given.key + "' has no effect: expected with it --robot-model sim");
    if (section == "robot_sim" || std::ranges::find(kRobotKeys, section) != kRobotKeys.end()) {
      parts.robot.push_back(given);
    } else if (std::ranges::find(kVisionKeys, section) != kVisionKeys.end()) {
      parts.vision.push_back(given);
    } else {
      throw InputError("--set: '" + given.key +
                       "' is no key of a replay; expected one that begins with a section of robot.yaml (robot, "
                       "controller, bridge, robot_sim) or vision.yaml (cameras, colour, tracker, targets), as "
                       "controller.gamma_rad2_m2, or tick_ms, state_hz, start_joint_position");
    }
  }
  return parts;
}

RunRequest::RunRequest() : threads(static_cast<int>(std::max(1U, std::thread::hardware_concurrency()))) {}

void RunRequest::add_to(CommandLine& app, bool session_required) {
  CommandOption log = app.option("SESSION", session, "recorded log with STEREO_IMAGES, or with TARGET");
  if (session_required) log.required();
  setup.add_to(app);
  app.option("--robot-model", robot,
             "source of ROBOT_STATE: ideal (a robot always at its last command), sim (MuJoCo), or recorded "
             "(the session's)")
      .one_of({"ideal", "sim", "recorded"})
      .show_default();
  app.option("--start-with", from, "replayed inputs: images, targets, or auto (images if the session has any)")
      .one_of({"auto", "images", "targets"})
      .show_default();
  app.option("--until", until_s, "end this many seconds after the session's first input").finite(0, 1e9);
}

void RunRequest::add_threads_to(CommandLine& app) {
  app.option("--threads", threads, "threads (default: all processors); the results are the same with any number")
      .whole(1, 1024);
}

ReplayFrom RunRequest::source() const {
  return from == "images" ? ReplayFrom::kImages : from == "targets" ? ReplayFrom::kTargets : replay_source(session);
}

ReplayOptions RunRequest::options(ReplayFrom source, const ConfigOverrides& overrides) const {
  const auto [robot_overrides, vision_overrides] = split(overrides, robot == "sim");
  ReplayOptions options{.session = session,
                        .from = source,
                        .robot = robot == "sim"        ? ReplayRobot::kSimulated
                                 : robot == "recorded" ? ReplayRobot::kRecorded
                                                       : ReplayRobot::kIdeal,
                        .config = RobotConfig::load(setup.robot_file(), robot_overrides),
                        .vision = std::nullopt,
                        .until_s = until_s,
                        .threads = threads};
  if (source == ReplayFrom::kImages) {
    options.vision = VisionConfig::load(setup.vision_file(session), vision_overrides);
  } else if (!vision_overrides.empty()) {
    throw InputError("--set: '" + vision_overrides.front().key +
                     "' is vision's, but this replay starts with targets; expected a session with images and no "
                     "--start-with targets");
  }
  return options;
}

}  // namespace multireach
