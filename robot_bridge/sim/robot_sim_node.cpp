#include "robot_bridge/sim/robot_sim_node.hpp"

#include <algorithm>
#include <cmath>
#include <multireach/perturbation_t.hpp>
#include <multireach/sim_step_t.hpp>
#include <utility>

#include "runtime/channels.hpp"
#include "runtime/config_keys.hpp"
#include "runtime/joint_fields.hpp"

namespace multireach {
namespace {

/// Without a command for this long, the joints hold the last commanded position.
constexpr int64_t kCommandExpires = 20000;  // us

/// False for NaN and for values that no joint position or speed has.
bool finite(double value) {
  return std::abs(value) < 1e6;
}

}  // namespace

namespace {

ConfigKeys<MujocoArmOptions> robot_sim_keys() {
  return ConfigKeys<MujocoArmOptions>("robot.yaml, section robot_sim",
                                      "The simulated robot: each joint follows its command as a spring and damper.")
      .number(
          "natural_frequency_rad_s", "rad/s", 1, 300, [](auto& o) -> auto& { return o.natural_frequency_rad_s; },
          "Natural frequency of the joints' position control.")
      .number(
          "damping_ratio", "", 0.1, 3, [](auto& o) -> auto& { return o.damping_ratio; },
          "Damping ratio of the joints' position control.");
}

}  // namespace

std::string robot_sim_config_reference() {
  return robot_sim_keys().reference();
}

MujocoArm simulated_arm(const RobotConfig& robot) {
  MujocoArmOptions options;
  if (const auto section = robot.section("robot_sim")) robot_sim_keys().read(*section, options);
  options.start = robot.start;
  options.limited = joint_names(robot.chain);
  try {
    return MujocoArm(read_text_file(robot.urdf_path), options);
  } catch (const StartPositionError& fault) {
    robot.file.fail("start_joint_position", "positions of joints of " + robot.urdf_path + ", which " + fault.what());
  } catch (const std::invalid_argument& fault) {
    throw InputError(robot.urdf_path + ": " + fault.what());
  }
}

bool is_valid_command(const joint_command_t& command, const MujocoArm& arm) {
  return std::ranges::all_of(command.joint_position, finite) && std::ranges::all_of(command.joint_velocity, finite) &&
         std::ranges::all_of(command.joint_name, [&](const std::string& joint) {
           return std::ranges::find(arm.joint_names(), joint) != arm.joint_names().end();
         });
}

void apply_command(const joint_command_t& command, MujocoArm& arm) {
  for (size_t i = 0; i < command.joint_name.size(); ++i) {
    arm.command(command.joint_name[i], command.joint_position[i], command.joint_velocity[i]);
  }
}

void put_joints(const MujocoArm& arm, robot_state_t& state) {
  state.simulated = true;
  state.num_joints = static_cast<int32_t>(arm.joint_names().size());
  state.joint_name = arm.joint_names();
  state.joint_position = arm.positions();
  state.joint_velocity = arm.velocities();
  state.joint_effort = arm.torques();
}

RobotSimNode::RobotSimNode(const RobotConfig& robot)
    : arm_(simulated_arm(robot)), state_period_us_(robot.state_period_us) {}

std::vector<std::string_view> RobotSimNode::inputs() const {
  return {channel::kJointCommand, channel::kPerturbation};
}

Receipt RobotSimNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox&) {
  if (channel == channel::kJointCommand) {
    receive_command(bytes);
  } else {
    receive_push(bytes);
  }
  return {Receipt::Effect::kConsumed};
}

void RobotSimNode::receive_push(std::span<const uint8_t> bytes) {
  const auto push = decode_and_count<perturbation_t>(bytes);
  if (!push) return;
  const Push next{push->link_name, Eigen::Map<const Eigen::Vector3d>(push->force_n), push->duration_us};
  const bool known = arm_.push(next.link, next.force_n);
  // The push above only tested link and force; restore the current push.
  arm_.release();
  if (push_) arm_.push(push_->link, push_->force_n);
  if (known && next.duration_us >= 0) {
    next_push_ = next;
    refusal_.clear();
  } else {
    constexpr size_t kLongestName = 100;
    refusal_ = "refused a push on '" + next.link.substr(0, kLongestName) +
               "': no link of the URDF, or no possible force or duration";
    ++counters_.refused;
  }
}

void RobotSimNode::receive_command(std::span<const uint8_t> bytes) {
  const auto command = decode_and_count<joint_command_t>(bytes);
  if (!command) return;
  const char* refusal = commands_.refusal_of(*command, run(), utime_);
  counters_.dropped = commands_.missing();
  if (!refusal && !is_valid_command(*command, arm_))
    refusal = "refused commands with other joints or impossible values";
  if (refusal) {
    refusal_ = refusal;
    ++counters_.refused;
    return;
  }
  commands_.obey(*command, utime_);
  apply_command(*command, arm_);
  command_digest_ = digest_of(bytes);
  commanded_utime_ = utime_;
}

std::string RobotSimNode::state() const {
  const std::string doing = commands_.sequence() < 0 ? "waiting for a command" : "running";
  return refusal_.empty() ? doing : doing + ", " + refusal_;
}

void RobotSimNode::update_push() {
  if (push_ && utime_ >= push_until_) {
    push_.reset();
    arm_.release();
  }
  if (!next_push_) return;
  push_ = next_push_;
  next_push_.reset();
  constexpr int64_t kForEver = int64_t{1} << 60;
  push_until_ = utime_ + std::min(push_->duration_us, kForEver);
  arm_.push(push_->link, push_->force_n);
}

void RobotSimNode::tick(Outbox& out) {
  if (steps_.empty()) update_push();
  const bool expired = commands_.sequence() < 0 || utime_ - commanded_utime_ > kCommandExpires;
  if (expired) arm_.hold();
  steps_.push_back(expired ? 0 : command_digest_);
  arm_.step();
  utime_ += kStepUs;
  if (utime_ % state_period_us_ >= kStepUs) return;
  robot_state_t state{};
  state.utime = utime_;
  state.sequence = sequence_++;
  state.run = run();
  state.command_sequence = commands_.sequence();
  put_joints(arm_, state);
  send(out, channel::kRobotState, state);
  sim_step_t step{};
  step.utime = utime_;
  step.sequence = state.sequence;
  step.state_digest = digest_of(out.back().bytes);
  step.previous_state_digest = std::exchange(state_digest_, step.state_digest);
  step.previous_command_digest = std::exchange(state_command_digest_, command_digest_);
  step.num_steps = static_cast<int32_t>(steps_.size());
  step.step_command_digest = std::move(steps_);
  steps_.clear();
  step.pushed_link = push_ ? push_->link : "";
  Eigen::Map<Eigen::Vector3d>(step.push_force_n) = push_ ? push_->force_n : Eigen::Vector3d::Zero();
  send_with_checksum(out, channel::kSimStep, step);
}

}  // namespace multireach
