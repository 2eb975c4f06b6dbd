#include "runtime/nodes/robot_config.hpp"

#include "runtime/digest.hpp"
#include "runtime/files.hpp"

namespace multireach {

RobotConfig RobotConfig::load(const std::string& path) {
  Config file = Config::load(path);
  file.finish({"robot", "controller", "bridge", "robot_sim"});
  const Config robot = file.section("robot");
  const std::string urdf_path = beside(path, robot.text("urdf"));
  Chain chain = load_chain(urdf_path, robot.text("base"), robot.text("tip"));
  robot.finish();
  const int64_t digest = digest_of(read_text_file(path) + read_text_file(urdf_path));
  return {std::move(file), urdf_path, std::move(chain), digest};
}

std::optional<Config> RobotConfig::section(const std::string& name) const {
  if (!file.has(name)) return std::nullopt;
  return file.section(name);
}

int64_t RobotConfig::state_period_us() const {
  const auto robot_sim = section("robot_sim");
  return 1000000 / (robot_sim ? robot_sim->integer("state_hz", 1, 1000, 200) : 200);
}

JointVector posture_from(const Config& config, const std::string& key, const Chain& chain) {
  const std::vector<double> values = config.numbers(key, -1);
  if (const auto fault = posture_fault(chain, values, "the posture"))
    config.fail(key, "a posture of the robot: " + *fault);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), chain.size());
}

}  // namespace multireach
