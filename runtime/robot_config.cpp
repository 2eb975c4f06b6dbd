#include "runtime/robot_config.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "kinematics/urdf_chain.hpp"
#include "kinematics/urdf_document.hpp"
#include "runtime/config_keys.hpp"
#include "runtime/digest.hpp"
#include "runtime/files.hpp"

namespace multireach {

namespace {

struct SharedValues {
  int64_t tick_us = 50000, state_hz = 200;
  std::map<std::string, double> start{};
};

ConfigKeys<SharedValues> shared_keys() {
  ConfigKeys<SharedValues> keys(
      "robot.yaml", "One robot: its arm, and one section for each process. Paths are relative to the file.");
  const auto read_elsewhere = [](const Config& config, SharedValues&) { config.has("robot"); };
  keys.other("robot", "section", "", "required", "The arm.", read_elsewhere)
      .number(
          "tick_ms", "ms", 1, 10000, [](auto& v) -> auto& { return v.tick_us; },
          "Longest time from one of the controller's set-points to the next; 50 ms in the paper (Sect. 4).", 1e3)
      .integer(
          "state_hz", "Hz", 1, 1000, [](auto& v) -> auto& { return v.state_hz; },
          "Rate of the simulated robot's ROBOT_STATE.")
      .other("start_joint_position", "map from joint names to numbers", "rad or m",
             "0, or the middle of limits that exclude 0", "Joint positions from which a simulated robot starts.",
             [](const Config& config, SharedValues& values) {
               if (config.has("start_joint_position")) values.start = config.named_numbers("start_joint_position");
             });
  for (const auto& [name, meaning] :
       {std::pair("controller", "The reaching controller."), std::pair("bridge", "The bridge."),
        std::pair("robot_sim", "The simulated robot."), std::pair("driver", "The driver of a real robot.")}) {
    keys.other(name, "section", "", "all defaults", meaning,
               [name = std::string(name)](const Config& config, SharedValues&) { config.has(name); });
  }
  return keys;
}

struct Arm {
  std::string urdf{}, base{}, tip{};
  std::vector<double> velocity{}, acceleration{}, jerk{};
};

ConfigKeys<Arm> arm_keys() {
  ConfigKeys<Arm> keys("robot.yaml, section robot", "The arm: a chain of joints in a URDF file.");
  const std::string list = "list, one number for each joint";
  keys.text(
          "urdf", [](auto& arm) -> auto& { return arm.urdf; }, "The URDF file.")
      .required();
  keys.text(
          "base", [](auto& arm) -> auto& { return arm.base; }, "Link at the start of the chain; its frame is W.")
      .required();
  keys.text(
          "tip", [](auto& arm) -> auto& { return arm.tip; }, "Link at the end of the chain, the hand.")
      .required();
  keys.other("joint_velocity_limits", list, "rad/s or m/s", "those of the URDF",
             "Largest speed of each joint, where it shall be lower than that of the URDF.",
             [](const Config& config, Arm& arm) {
               arm.velocity = config.numbers("joint_velocity_limits", -1, std::vector<double>{});
             });
  keys.other("joint_acceleration_limits", list, "rad/s² or m/s²", "speed limit / 0.1 s",
             "Largest acceleration of each joint, which the controller plans with and the bridge enforces.",
             [](const Config& config, Arm& arm) {
               arm.acceleration = config.numbers("joint_acceleration_limits", -1, std::vector<double>{});
             });
  keys.other("joint_jerk_limits", list, "rad/s³ or m/s³", "acceleration limit / 0.01 s",
             "Largest jerk of each joint, which the bridge enforces.", [](const Config& config, Arm& arm) {
               arm.jerk = config.numbers("joint_jerk_limits", -1, std::vector<double>{});
             });
  return keys;
}

/// The limits under `key`, one for each joint of the chain; empty when none are given.
JointVector limits_from(const Config& section, const std::string& key, const std::vector<double>& values,
                        const Chain& chain) {
  if (values.empty()) return {};
  const bool positive = std::ranges::all_of(values, [](double value) { return value > 0; });
  if (!positive || values.size() != static_cast<size_t>(chain.size()))
    section.fail(key, "a positive number for each of the " + std::to_string(chain.size()) + " joints");
  return Eigen::Map<const Eigen::VectorXd>(values.data(), chain.size());
}

/// The chain with the lower speed limits of the robot.yaml.
Chain with_velocity_limits(const Chain& chain, const Config& section, const std::vector<double>& values) {
  const JointVector limits = limits_from(section, "joint_velocity_limits", values, chain);
  if (limits.size() == 0) return chain;
  std::vector<Joint> joints = chain.joints();
  std::vector<Eigen::Isometry3d> fixed;
  for (int i = 0; i <= chain.size(); ++i) fixed.push_back(chain.fixed(i));
  for (int i = 0; i < chain.size(); ++i) {
    if (limits[i] > joints[static_cast<size_t>(i)].velocity)
      section.fail("joint_velocity_limits", "no speed above that of the URDF; joint '" + chain.joint(i).name +
                                                "' has " + config_number(chain.joint(i).velocity));
    joints[static_cast<size_t>(i)].velocity = limits[i];
  }
  return {std::move(joints), std::move(fixed), chain.base(), chain.tip()};
}

Chain chain_of(const Arm& arm, const std::string& urdf_path, const Config& section) {
  if (std::error_code error; !std::filesystem::exists(urdf_path, error)) section.fail("urdf", "an existing file");
  const std::string xml = read_text_file(urdf_path);
  try {
    return chain_from_urdf(xml, arm.base, arm.tip);
  } catch (const UnknownLinkError& fault) {
    section.fail(fault.which, "a link of " + urdf_path + ", which has " + fault.links);
  } catch (const std::invalid_argument& fault) {
    throw InputError(urdf_path + ": " + fault.what());
  }
}

constexpr double kMostTurns = 4;          // of a joint in either direction
constexpr double kFastest = 30;           // rad/s
constexpr double kShortestStart = 0.005;  // s, from rest to the speed limit

}  // namespace

std::vector<std::string> doubts_about(const RobotConfig& robot) {
  std::vector<std::string> doubts;
  const auto above = urdf_tree(read_text_file(robot.urdf_path)).ancestry(robot.chain.base());
  if (std::ranges::find(above, robot.chain.tip()) != above.end()) {
    doubts.push_back("the tip '" + robot.chain.tip() + "' is nearer to the root of the URDF than the base '" +
                     robot.chain.base() + "'; are they swapped?");
  }
  const auto doubt = [&](const Joint& joint, const char* what, double value, const char* unit) {
    doubts.push_back("joint '" + joint.name + "': " + what + " of " + config_number(value) + " " + unit +
                     "; in degrees? Angles are in radians");
  };
  for (int i = 0; i < robot.chain.size(); ++i) {
    const Joint& joint = robot.chain.joint(i);
    if (joint.type == Joint::Type::kPrismatic) continue;
    for (const double limit : {joint.lower, joint.upper}) {
      const double turns = std::abs(limit) / (2 * std::numbers::pi);
      if (std::isfinite(limit) && turns > kMostTurns) doubt(joint, "a position limit", limit, "rad");
    }
    if (std::isfinite(joint.velocity) && joint.velocity > kFastest)
      doubt(joint, "a velocity limit", joint.velocity, "rad/s");
    const JointVector& acceleration = robot.joint_acceleration_limits;
    if (acceleration.size() > 0 && acceleration[i] * kShortestStart > joint.velocity)
      doubt(joint, "an acceleration limit", acceleration[i], "rad/s^2");
  }
  return doubts;
}

RobotConfig RobotConfig::load(const std::string& file_or_folder, const ConfigOverrides& overrides) {
  std::error_code error;
  const bool folder = std::filesystem::is_directory(file_or_folder, error);
  const std::string path = folder ? (std::filesystem::path(file_or_folder) / "robot.yaml").string() : file_or_folder;
  Config file = Config::load(path, overrides);
  const Config section = file.section("robot");
  Arm arm;
  arm_keys().read(section, arm);
  const std::string urdf_path = resolve_relative(path, arm.urdf);
  Chain chain = with_velocity_limits(chain_of(arm, urdf_path, section), section, arm.velocity);
  SharedValues shared;
  shared_keys().read(file, shared);
  RobotConfig robot{std::move(file), urdf_path, std::move(chain)};
  robot.tick_us = shared.tick_us;
  robot.state_period_us = 1000000 / shared.state_hz;
  robot.start = std::move(shared.start);
  robot.joint_acceleration_limits = limits_from(section, "joint_acceleration_limits", arm.acceleration, robot.chain);
  robot.joint_jerk_limits = limits_from(section, "joint_jerk_limits", arm.jerk, robot.chain);
  robot.digest = digest_of(read_text_file(path) + read_text_file(urdf_path) + text_of(overrides));
  return robot;
}

std::string robot_config_reference() {
  return shared_keys().reference() + "\n" + arm_keys().reference();
}

std::optional<Config> RobotConfig::section(const std::string& name) const {
  if (!file.has(name)) return std::nullopt;
  return file.section(name);
}

JointVector joint_configuration_from(const Config& config, const std::string& key, const Chain& chain) {
  const std::vector<double> values = config.numbers(key, -1);
  if (const auto fault = joint_configuration_fault(chain, values, "the joint configuration"))
    config.fail(key, "a joint configuration of the robot: " + *fault);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), chain.size());
}

}  // namespace multireach
