#include "runtime/robot_config.hpp"

#include <filesystem>

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
          "Period of the controller's set-points, which the bridge interpolates; 50 ms in the paper (Sect. 4).", 1e3)
      .integer(
          "state_hz", "Hz", 1, 1000, [](auto& v) -> auto& { return v.state_hz; },
          "Rate of the simulated robot's ROBOT_STATE.")
      .other("start_joint_position", "map from joint names to numbers", "rad or m", "0, or the limit nearest to it",
             "Joint positions from which a simulated robot starts.", [](const Config& config, SharedValues& values) {
               if (config.has("start_joint_position")) values.start = config.named_numbers("start_joint_position");
             });
  for (const auto& [name, meaning] :
       {std::pair("controller", "The reaching controller."), std::pair("bridge", "The bridge."),
        std::pair("robot_sim", "The simulated robot.")}) {
    keys.other(name, "section", "", "all defaults", meaning,
               [name = std::string(name)](const Config& config, SharedValues&) { config.has(name); });
  }
  return keys;
}

struct Arm {
  std::string urdf{}, base{}, tip{};
};

ConfigKeys<Arm> arm_keys() {
  return ConfigKeys<Arm>("robot.yaml, section robot", "The arm: a chain of joints in a URDF file.")
      .text(
          "urdf", [](auto& arm) -> auto& { return arm.urdf; }, "The URDF file.")
      .required()
      .text(
          "base", [](auto& arm) -> auto& { return arm.base; }, "Link at the start of the chain; its frame is W.")
      .required()
      .text(
          "tip", [](auto& arm) -> auto& { return arm.tip; }, "Link at the end of the chain, the hand.")
      .required();
}

}  // namespace

RobotConfig RobotConfig::load(const std::string& file_or_folder) {
  std::error_code error;
  const bool folder = std::filesystem::is_directory(file_or_folder, error);
  const std::string path = folder ? (std::filesystem::path(file_or_folder) / "robot.yaml").string() : file_or_folder;
  Config file = Config::load(path);
  Arm arm;
  arm_keys().read(file.section("robot"), arm);
  const std::string urdf_path = beside(path, arm.urdf);
  Chain chain = load_chain(urdf_path, arm.base, arm.tip);
  SharedValues shared;
  shared_keys().read(file, shared);
  const int64_t digest = digest_of(read_text_file(path) + read_text_file(urdf_path));
  return {std::move(file),        urdf_path, std::move(chain), digest, shared.tick_us, 1000000 / shared.state_hz,
          std::move(shared.start)};
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
  if (const auto fault = posture_fault(chain, values, "the joint configuration"))
    config.fail(key, "a joint configuration of the robot: " + *fault);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), chain.size());
}

}  // namespace multireach
