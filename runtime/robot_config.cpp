#include "runtime/robot_config.hpp"

#include "runtime/digest.hpp"
#include "runtime/files.hpp"

namespace multireach {

RobotConfig RobotConfig::load(const std::string& path) {
  Config file = Config::load(path);
  const Config robot = file.section("robot");
  const std::string urdf_path = beside(path, robot.text("urdf"));
  Chain chain = load_chain(urdf_path, robot.text("base"), robot.text("tip"));
  robot.finish();
  const int64_t digest = digest_of(read_text_file(path) + read_text_file(urdf_path));
  const auto tick_us = static_cast<int64_t>(file.number("tick_ms", 1, 10000, 50) * 1e3);
  const int64_t state_period_us = 1000000 / file.integer("state_hz", 1, 1000, 200);
  file.finish({"controller", "bridge", "robot_sim"});
  return {std::move(file), urdf_path, std::move(chain), digest, tick_us, state_period_us};
}

std::optional<Config> RobotConfig::section(const std::string& name) const {
  if (!file.has(name)) return std::nullopt;
  return file.section(name);
}

JointVector posture_from(const Config& config, const std::string& key, const Chain& chain) {
  const std::vector<double> values = config.numbers(key, -1);
  if (const auto fault = posture_fault(chain, values, "the posture"))
    config.fail(key, "a posture of the robot: " + *fault);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), chain.size());
}

}  // namespace multireach
