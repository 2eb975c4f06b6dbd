#include "runtime/nodes/bridge_node.hpp"

#include <multireach/joint_command_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/robot_state_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/nodes/controller_node.hpp"
#include "runtime/nodes/joint_fields.hpp"

namespace multireach {

robot_bridge::BridgeOptions bridge_options_from(const RobotConfig& robot) {
  robot_bridge::BridgeOptions options;
  options.setpoint_period_us = reach_options_from(robot).tick_us;
  const auto section = robot.section("bridge");
  if (!section) return options;
  const Config& config = *section;
  options.delay_us = static_cast<int64_t>(config.number("delay_ms", 0, 1000, options.delay_us * 1e-3) * 1e3);
  options.speed_where_unlimited =
      config.number("speed_where_unlimited_rad_s", 1e-3, 1e3, options.speed_where_unlimited);
  config.finish();
  return options;
}

BridgeNode::BridgeNode(const RobotConfig& robot)
    : options_(bridge_options_from(robot)),
      chain_(robot.chain),
      bridge_(robot.chain, options_),
      joint_names_(joint_names(robot.chain)) {}

std::vector<std::string_view> BridgeNode::inputs() const {
  return {channel::kJointSetpoint, channel::kRobotState};
}

std::optional<int64_t> BridgeNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox&) {
  if (channel == channel::kRobotState) {
    const auto message = take<robot_state_t>(bytes);
    if (!message) return std::nullopt;
    counters_.dropped += robot_states_.missing_before(message->sequence);
    const auto theta = from_fields(chain_, message->joint_name, message->angle_rad);
    if (!theta || !bridge_.measured(*theta)) {
      ++counters_.refused;
    } else if (!bridge_.next_tick()) {
      robot_state_sequence_ = message->sequence;
    }
    return std::nullopt;
  }
  const auto message = take<joint_setpoint_t>(bytes);
  if (!message) return std::nullopt;
  counters_.dropped += setpoints_.missing_before(message->sequence);
  const auto theta = from_fields(chain_, message->joint_name, message->angle_rad);
  if (!theta || !plausible_utime(message->utime) ||
      !bridge_.setpoint({.utime = message->utime, .sequence = message->sequence, .theta = *theta})) {
    ++counters_.refused;
    return std::nullopt;
  }
  return message->utime;
}

void BridgeNode::tick(Outbox& out) {
  last_ = bridge_.tick();
  if (last_.limited) ++counters_.limited;
  joint_command_t command;
  command.utime = last_.utime;
  command.sequence = sequence_++;
  command.setpoint_sequence = last_.setpoint_sequence;
  command.robot_state_sequence = robot_state_sequence_;
  command.holding = last_.holding;
  command.limited = last_.limited;
  command.num_joints = chain_.size();
  command.joint_name = joint_names_;
  command.angle_rad = to_field(last_.theta);
  command.velocity_rad_s = to_field(last_.velocity);
  send(out, channel::kJointCommand, command);
}

std::string BridgeNode::state() const {
  if (!bridge_.knows_robot()) return "waiting for the robot";
  if (!bridge_.next_tick()) return "waiting for a set-point";
  return last_.holding ? "holding" : "running";
}

}  // namespace multireach
