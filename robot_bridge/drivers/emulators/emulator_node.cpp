#include "robot_bridge/drivers/emulators/emulator_node.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <Eigen/Core>
#include <multireach/perturbation_t.hpp>

#include "kinematics/default_joint_position.hpp"
#include "robot_bridge/drivers/emulators/iiwa_emulator.hpp"
#include "robot_bridge/drivers/emulators/panda_emulator.hpp"
#include "robot_bridge/drivers/emulators/servo_emulator.hpp"
#include "robot_bridge/drivers/emulators/ur_emulator.hpp"
#include "runtime/channels.hpp"

namespace multireach::drivers {
namespace {

constexpr double kCollisionForce = 20;  // N

}  // namespace

std::vector<std::string_view> EmulatorNode::inputs() const {
  std::vector<std::string_view> channels{channel::kPerturbation};
  port_.append_inputs(channels);
  return channels;
}

Receipt EmulatorNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) {
  if (channel != channel::kPerturbation) {
    ++counters_.received;
    port_.receive(channel, bytes, now(), out);
  } else if (const auto push = decode_and_count<perturbation_t>(bytes)) {
    if (Eigen::Map<const Eigen::Vector3d>(push->force_n).norm() >= kCollisionForce) emulator_->collide();
  }
  return {Receipt::Effect::kConsumed};
}

void EmulatorNode::tick(Outbox& out) {
  port_.tick(now(), out);
  utime_ += kTickUs;
  if (emulator_->fault() == reported_) return;
  reported_ = emulator_->fault();
  if (reported_.empty()) {
    spdlog::info("the emulated robot runs");
  } else {
    spdlog::warn("the emulated robot has stopped: {}", reported_);
  }
}

std::unique_ptr<Emulator> make_emulator(const RobotConfig& robot, const DriverConfig& config) {
  // The manufacturer's limits, not the gentler ones of the robot.yaml.
  const Chain chain = load_chain(robot.urdf_path, robot.chain.base(), robot.chain.tip());
  JointVector start(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    const auto given = robot.start.find(chain.joint(i).name);
    start[i] = given == robot.start.end() ? default_joint_position(chain.lower()[i], chain.upper()[i]) : given->second;
    if (start[i] < chain.lower()[i] || start[i] > chain.upper()[i]) {
      throw InputError(
          fmt::format("{}: key 'start_joint_position.{}' is {:.6g}; expected {:.6g} to {:.6g}, the joint's limits",
                      robot.file.file(), chain.joint(i).name, start[i], chain.lower()[i], chain.upper()[i]));
    }
  }
  if (config.name == "iiwa") return std::make_unique<IiwaEmulator>(chain, start);
  if (config.name == "panda" && chain.size() == 7)
    return std::make_unique<PandaEmulator>(chain, start, PandaEmulatorOptions{.model = config.franka_model});
  if (config.name == "ur" && chain.size() == 6) return std::make_unique<UrEmulator>(chain, start, config.ur.e_series);
  if (config.name == "dynamixel") return std::make_unique<DynamixelEmulator>(chain, start, config.servo);
  if (config.name == "feetech") return std::make_unique<FeetechEmulator>(chain, start, config.servo);
  throw InputError("the driver '" + config.name + "' has no emulator for this arm");
}

}  // namespace multireach::drivers
