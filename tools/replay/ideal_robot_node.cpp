#include "tools/replay/ideal_robot_node.hpp"

#include <multireach/joint_command_t.hpp>
#include <multireach/robot_state_t.hpp>

#include "kinematics/default_joint_position.hpp"
#include "runtime/channels.hpp"
#include "runtime/joint_fields.hpp"

namespace multireach {

IdealRobotNode::IdealRobotNode(const RobotConfig& robot)
    : chain_(robot.chain),
      period_us_(robot.state_period_us),
      config_digest_(robot.digest),
      joint_names_(joint_names(robot.chain)) {
  theta_ = velocity_ = JointVector::Zero(chain_.size());
  for (int i = 0; i < chain_.size(); ++i) theta_[i] = default_joint_position(chain_.lower()[i], chain_.upper()[i]);
  for (const auto& [joint, position] : robot.start) {
    if (const int at = chain_.index_of(joint); at >= 0) theta_[at] = position;
  }
  theta_ = chain_.clamped(theta_);
}

std::vector<std::string_view> IdealRobotNode::inputs() const {
  return {channel::kJointCommand};
}

Receipt IdealRobotNode::receive(std::string_view, std::span<const uint8_t> bytes, Outbox&) {
  newest_command_.assign(bytes.begin(), bytes.end());
  return {Receipt::Effect::kReplaces};
}

void IdealRobotNode::apply_command() {
  const auto command = decode_and_count<joint_command_t>(newest_command_);
  newest_command_.clear();
  if (!command) return;
  const auto theta = from_fields(chain_, command->joint_name, command->joint_position);
  const auto velocity = from_fields(chain_, command->joint_name, command->joint_velocity);
  if (!theta || !velocity || !theta->allFinite() || !velocity->allFinite()) {
    ++counters_.refused;
    return;
  }
  theta_ = *theta;
  velocity_ = *velocity;
  command_sequence_ = command->sequence;
}

void IdealRobotNode::tick(Outbox& out) {
  if (!newest_command_.empty()) apply_command();
  robot_state_t state{};
  state.utime = utime_;
  state.sequence = sequence_++;
  state.run = run();
  state.command_sequence = command_sequence_;
  state.simulated = true;
  state.num_joints = chain_.size();
  state.joint_name = joint_names_;
  state.joint_position = to_field(theta_);
  state.joint_velocity = to_field(velocity_);
  state.joint_effort.assign(joint_names_.size(), 0.0);
  utime_ += period_us_;
  send(out, channel::kRobotState, state);
}

}  // namespace multireach
