#include "runtime/nodes/controller_node.hpp"

#include <cstdlib>
#include <multireach/controller_state_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/nodes/joint_fields.hpp"

namespace multireach {
namespace {

constexpr int64_t kOtherClock = 1000000;  // us: a target this far from the next tick is on another time line

}  // namespace

controller::ReachOptions reach_options_from(const RobotConfig& robot) {
  controller::ReachOptions options;
  const auto section = robot.section("controller");
  if (!section) return options;
  const Config& config = *section;
  config.choice("law", {"paper"}, "paper");
  options.law.gamma = config.number("gamma_rad2_m2", 0, 1e12, options.law.gamma);
  options.law.gains.alpha = config.number("alpha_per_step", 1e-6, 1, options.law.gains.alpha);
  options.law.gains.beta = config.number("beta_per_step", 1e-6, 1, options.law.gains.beta);
  options.steps_per_tick = static_cast<int>(config.integer("steps_per_tick", 1, 1000, options.steps_per_tick));
  options.tick_us = static_cast<int64_t>(config.number("tick_ms", 1, 10000, options.tick_us * 1e-3) * 1e3);
  options.jump_m = config.number("jump_m", 1e-6, 1e3, options.jump_m);
  options.drift_m = config.number("drift_m", 1e-6, 1e3, options.drift_m);
  options.lost_after_us =
      static_cast<int64_t>(config.number("lost_after_s", 0, 1e6, options.lost_after_us * 1e-6) * 1e6);
  if (config.choice("without_target", {"hold", "rest"}, "hold") == "rest") {
    options.without_target = controller::WithoutTarget::kGoToRest;
  }
  if (config.has("rest_rad")) options.rest = posture_from(config, "rest_rad", robot.chain);
  options.posture_search.seed = static_cast<uint64_t>(config.integer("seed", 0, INT64_MAX, 1));
  config.finish();
  return options;
}

ControllerNode::ControllerNode(const RobotConfig& robot)
    : controller_(robot.chain, reach_options_from(robot)), joint_names_(joint_names(robot.chain)) {}

std::vector<std::string_view> ControllerNode::inputs() const {
  return {channel::kTarget, channel::kRobotState};
}

std::optional<int64_t> ControllerNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox&) {
  if (channel == channel::kTarget) return receive_target(bytes);
  receive_robot_state(bytes);
  return std::nullopt;
}

std::optional<int64_t> ControllerNode::receive_target(std::span<const uint8_t> bytes) {
  const auto message = take<target_t>(bytes);
  if (!message) return std::nullopt;
  counters_.dropped += targets_.missing_before(message->sequence);
  const Eigen::Vector3d position = Eigen::Map<const Eigen::Vector3d>(message->position_m);
  const Eigen::Vector3d velocity = Eigen::Map<const Eigen::Vector3d>(message->velocity_m_s);
  const bool seen = message->status == target_t::STATUS_TRACKED;
  if (!plausible_utime(message->utime) || (seen && !(position.allFinite() && velocity.allFinite()))) {
    ++counters_.refused;
    return std::nullopt;
  }
  if (!controller_.started()) return std::nullopt;
  const auto next = controller_.next_tick();
  if (!next && !seen) return std::nullopt;  // the grid begins with the first target that is seen
  if (!next || std::abs(message->utime - *next) > kOtherClock) controller_.restart_grid(message->utime);
  const bool taken =
      controller_.observe({.utime = message->utime, .seen = seen, .position = position, .velocity = velocity});
  if (!taken) {
    ++counters_.refused;
    return std::nullopt;
  }
  target_sequence_ = message->sequence;
  return message->utime;
}

void ControllerNode::receive_robot_state(std::span<const uint8_t> bytes) {
  const auto message = take<robot_state_t>(bytes);
  if (!message) return;
  counters_.dropped += robot_states_.missing_before(message->sequence);
  if (controller_.next_tick()) return;  // the controller integrates its own posture
  const auto theta = from_fields(controller_.chain(), message->joint_name, message->angle_rad);
  if (theta && controller_.start(*theta)) {
    robot_state_sequence_ = message->sequence;
  } else {
    ++counters_.refused;
  }
}

void ControllerNode::tick(Outbox& out) {
  last_ = controller_.tick();
  joint_setpoint_t setpoint;
  setpoint.utime = last_.utime;
  setpoint.sequence = sequence_;
  setpoint.tick = last_.tick;
  setpoint.target_sequence = target_sequence_;
  setpoint.robot_state_sequence = robot_state_sequence_;
  setpoint.obstacles_sequence = -1;
  setpoint.num_joints = controller_.chain().size();
  setpoint.joint_name = joint_names_;
  setpoint.angle_rad = to_field(last_.theta);
  setpoint.velocity_rad_s = to_field(last_.velocity);
  send(out, channel::kJointSetpoint, setpoint);

  controller_state_t state;
  state.utime = last_.utime;
  state.sequence = sequence_++;
  state.tick = last_.tick;
  state.mode = static_cast<int8_t>(last_.mode);
  state.target_lost = last_.target_lost;
  state.target_out_of_reach = last_.target_out_of_reach;
  Eigen::Map<Eigen::Vector3d>(state.hand_position_m) = last_.x;
  Eigen::Map<Eigen::Vector3d>(state.hand_target_m) = last_.x_T;
  state.gamma_rad2_m2 = controller_.options().law.gamma;
  state.condition_number = last_.condition_number;
  state.attractor_residual_m = last_.attractor_residual_m;
  state.posture_choices = last_.posture_choices;
  state.num_joints = setpoint.num_joints;
  state.joint_name = joint_names_;
  state.angle_rad = setpoint.angle_rad;
  state.target_angle_rad = to_field(last_.theta_target);
  state.weight_rad2_m2 = to_field(last_.weights);
  send(out, channel::kControllerState, state);
}

std::string ControllerNode::state() const {
  if (!controller_.started()) return "waiting for the robot";
  if (!controller_.next_tick()) return "waiting for a target";
  std::string text;
  switch (last_.mode) {
    case controller::ReachMode::kWaiting:
      text = "waiting";
      break;
    case controller::ReachMode::kReaching:
      text = "reaching";
      break;
    case controller::ReachMode::kHolding:
      text = "holding";
      break;
    case controller::ReachMode::kResting:
      text = "resting";
      break;
  }
  if (last_.target_lost) text += ", target lost";
  if (last_.target_out_of_reach) text += ", target out of reach";
  return text;
}

}  // namespace multireach
