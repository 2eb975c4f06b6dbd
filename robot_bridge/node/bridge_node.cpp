#include "robot_bridge/node/bridge_node.hpp"

#include <multireach/joint_setpoint_t.hpp>
#include <multireach/robot_state_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/config_keys.hpp"
#include "runtime/joint_fields.hpp"

namespace multireach {

namespace {

ConfigKeys<robot_bridge::BridgeOptions> bridge_keys() {
  return ConfigKeys<robot_bridge::BridgeOptions>("robot.yaml, section bridge", "The bridge.")
      .number(
          "delay_ms", "ms", 0, 1000, [](auto& o) -> auto& { return o.delay_us; },
          "How late a set-point may arrive without affecting the motion.", 1e3)
      .number(
          "speed_where_unlimited", "rad/s or m/s", 1e-3, 1e3, [](auto& o) -> auto& { return o.speed_where_unlimited; },
          "Speed limit of joints for which the URDF gives none.");
}

}  // namespace

robot_bridge::BridgeOptions bridge_options_from(const RobotConfig& robot) {
  robot_bridge::BridgeOptions options;
  options.setpoint_period_us = robot.tick_us;
  if (const auto section = robot.section("bridge")) bridge_keys().read(*section, options);
  return options;
}

std::string bridge_config_reference() {
  return bridge_keys().reference();
}

BridgeNode::BridgeNode(const RobotConfig& robot)
    : options_(bridge_options_from(robot)),
      chain_(robot.chain),
      bridge_(robot.chain, options_),
      config_digest_(robot.digest) {
  command_.joint_name = joint_names(robot.chain);
  command_.num_joints = chain_.size();
}

std::vector<std::string_view> BridgeNode::inputs() const {
  return {channel::kJointSetpoint, channel::kRobotState};
}

Receipt BridgeNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox&) {
  if (channel == channel::kRobotState) {
    const auto message = take<robot_state_t>(bytes);
    if (!message) return {};
    counters_.dropped += robot_states_.missing_before(message->sequence);
    const auto theta = from_fields(chain_, message->joint_name, message->joint_position);
    if (!theta || !bridge_.measured(*theta)) {
      ++counters_.refused;
    } else if (!bridge_.next_tick()) {
      robot_state_sequence_ = message->sequence;
      return {Receipt::Effect::kReplaces, std::nullopt, message->sequence};
    }
    return {};
  }
  const auto message = take<joint_setpoint_t>(bytes);
  if (!message) return {};
  counters_.dropped += setpoints_.missing_before(message->sequence);
  const auto theta = from_fields(chain_, message->joint_name, message->joint_position);
  if (!theta || !plausible_utime(message->utime) ||
      !bridge_.setpoint({.utime = message->utime, .sequence = message->sequence, .theta = *theta})) {
    ++counters_.refused;
    return {};
  }
  return {Receipt::Effect::kTaken, message->utime, message->sequence};
}

void BridgeNode::tick(Outbox& out) {
  last_ = bridge_.tick();
  if (last_.limited) ++counters_.limited;
  command_.utime = last_.utime;
  command_.sequence = sequence_++;
  command_.setpoint_sequence = last_.setpoint_sequence;
  command_.robot_state_sequence = robot_state_sequence_;
  command_.holding = last_.holding;
  command_.limited = last_.limited;
  command_.joint_position.assign(last_.theta.begin(), last_.theta.end());
  command_.joint_velocity.assign(last_.velocity.begin(), last_.velocity.end());
  send(out, channel::kJointCommand, command_);
}

std::string BridgeNode::state() const {
  if (!bridge_.knows_robot()) return "waiting for the robot";
  if (!bridge_.next_tick()) return "waiting for a set-point";
  return last_.holding ? "holding" : "running";
}

}  // namespace multireach
