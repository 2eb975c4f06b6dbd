#include "tools/robot_sim/robot_sim_node.hpp"

#include <algorithm>
#include <cmath>
#include <multireach/joint_command_t.hpp>
#include <multireach/perturbation_t.hpp>
#include <multireach/robot_state_t.hpp>

#include "runtime/channels.hpp"

namespace multireach {
namespace {

/// Without a command for this long, the joints stop where they were last told to be.
constexpr int64_t kCommandExpires = 20000;  // us

MujocoArm load_arm(const RobotConfig& robot) {
  MujocoArmOptions options;
  if (const auto section = robot.section("robot_sim")) {
    options.natural_frequency_rad_s =
        section->number("natural_frequency_rad_s", 1, 300, options.natural_frequency_rad_s);
    options.damping_ratio = section->number("damping_ratio", 0.1, 3, options.damping_ratio);
    if (section->has("start_rad")) options.start = section->named_numbers("start_rad");
    section->finish({"state_hz"});
  }
  try {
    return MujocoArm(read_text_file(robot.urdf_path), options);
  } catch (const std::invalid_argument& fault) {
    throw InputError(robot.urdf_path + ": " + fault.what());
  }
}

}  // namespace

RobotSimNode::RobotSimNode(const RobotConfig& robot) : arm_(load_arm(robot)) {
  if (const auto section = robot.section("robot_sim")) {
    state_period_us_ = 1000000 / section->integer("state_hz", 1, 1000, 200);
  }
}

std::vector<std::string_view> RobotSimNode::inputs() const {
  return {channel::kJointCommand, channel::kPerturbation};
}

std::optional<int64_t> RobotSimNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox&) {
  if (channel == channel::kJointCommand) {
    receive_command(bytes);
  } else if (const auto push = take<perturbation_t>(bytes)) {
    const Eigen::Vector3d force = Eigen::Map<const Eigen::Vector3d>(push->force_n);
    if (!arm_.push(push->link_name, force, static_cast<double>(push->duration_us) * 1e-6)) ++counters_.refused;
  }
  return std::nullopt;
}

void RobotSimNode::receive_command(std::span<const uint8_t> bytes) {
  const auto command = take<joint_command_t>(bytes);
  if (!command) return;
  counters_.dropped += commands_.missing_before(command->sequence);
  // Also false for NaN; no joint has such a position or speed.
  const auto finite = [](double value) { return std::abs(value) < 1e6; };
  const bool sensible = std::ranges::all_of(command->angle_rad, finite) &&
                        std::ranges::all_of(command->velocity_rad_s, finite) &&
                        std::ranges::all_of(command->joint_name, [this](const std::string& joint) {
                          return std::ranges::find(arm_.joint_names(), joint) != arm_.joint_names().end();
                        });
  if (!sensible) {
    ++counters_.refused;
    return;
  }
  for (size_t i = 0; i < command->joint_name.size(); ++i) {
    arm_.command(command->joint_name[i], command->angle_rad[i], command->velocity_rad_s[i]);
  }
  command_sequence_ = command->sequence;
  commanded_utime_ = utime_;
}

void RobotSimNode::tick(Outbox& out) {
  if (utime_ - commanded_utime_ > kCommandExpires) arm_.hold();
  arm_.step();
  utime_ += kStepUs;
  if (utime_ % state_period_us_ >= kStepUs) return;
  robot_state_t state;
  state.utime = utime_;
  state.sequence = sequence_++;
  state.command_sequence = command_sequence_;
  state.num_joints = static_cast<int32_t>(arm_.joint_names().size());
  state.joint_name = arm_.joint_names();
  state.angle_rad = arm_.positions();
  state.velocity_rad_s = arm_.velocities();
  state.torque_n_m = arm_.torques();
  send(out, channel::kRobotState, state);
}

}  // namespace multireach
