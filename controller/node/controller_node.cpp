#include "controller/node/controller_node.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <multireach/bridge_state_t.hpp>
#include <multireach/controller_state_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/obstacles_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_choice_t.hpp>
#include <multireach/target_t.hpp>
#include <stdexcept>
#include <utility>

#include "controller/collision/link_at.hpp"
#include "controller/node/controller_config.hpp"
#include "runtime/channels.hpp"
#include "runtime/files.hpp"
#include "runtime/joint_fields.hpp"
#include "runtime/time_line.hpp"

namespace multireach {
namespace {

const char* blocked_text(controller::Blocked blocked) {
  switch (blocked) {
    case controller::Blocked::kNo:
      return "";
    case controller::Blocked::kTargetInObstacle:
      return "the target is inside an obstacle or too near to it";
    case controller::Blocked::kObstacle:
      return "an obstacle or the arm itself is in the way";
    case controller::Blocked::kUnknown:
      break;
  }
  return "no way found";
}

/// Nothing for a target without an orientation, or whose quaternion is not of unit length.
std::optional<Eigen::Matrix3d> orientation_of(const target_t& target) {
  const double* wxyz = target.orientation_wxyz;
  const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (!target.has_orientation || !(std::abs(q.norm() - 1) < 1e-3)) return std::nullopt;
  return q.normalized().toRotationMatrix();
}

controller::ReachController controller_from(const RobotConfig& robot) {
  const controller::ReachOptions options = reach_options_from(robot);
  try {
    return {robot.chain, options};
  } catch (const std::invalid_argument& error) {
    throw InputError(robot.file.file() + ": section 'controller': " + error.what());
  }
}

}  // namespace

ControllerNode::ControllerNode(const RobotConfig& robot)
    : controller_(controller_from(robot)),
      joint_names_(joint_names(robot.chain)),
      target_name_(target_name_from(robot)),
      config_digest_(robot.digest) {}

std::vector<std::string_view> ControllerNode::inputs() const {
  return {channel::kTarget, channel::kObstacles, channel::kTargetChoice, channel::kRobotState, channel::kBridgeState};
}

Receipt ControllerNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox&) {
  if (channel == channel::kTarget) return receive_target(bytes);
  if (channel == channel::kObstacles) return receive_obstacles(bytes);
  if (channel == channel::kTargetChoice) return receive_choice(bytes);
  if (channel == channel::kRobotState) return receive_robot_state(bytes);
  if (channel == channel::kBridgeState) return receive_bridge_state(bytes);
  throw unknown_input(channel);
}

Receipt ControllerNode::receive_target(std::span<const uint8_t> bytes) {
  const auto message = decode_and_count<target_t>(bytes);
  if (!message) return {};
  // Every publisher counts its own messages; those of the one that is followed tell what was lost.
  const auto followed = target_run_.run();
  if (followed && *followed == message->run) counters_.dropped += targets_.newly_lost(message->sequence, message->run);
  const Eigen::Vector3d position = Eigen::Map<const Eigen::Vector3d>(message->position_m);
  const Eigen::Vector3d velocity = Eigen::Map<const Eigen::Vector3d>(message->velocity_m_s);
  const bool ambiguous = message->status == target_t::STATUS_AMBIGUOUS;  // treated as lost
  const bool seen = message->status != target_t::STATUS_LOST && !ambiguous;
  if (choice_.kind == target_choice_t::NONE) return {};
  const bool named = choice_.kind == target_choice_t::NAMED;
  if (named ? message->name != choice_.name : target_name_ && message->name != *target_name_) return {};
  uncalibrated_ = message->status == target_t::STATUS_UNCALIBRATED;
  if (!ambiguous && (message->status < target_t::STATUS_LOST || message->status > target_t::STATUS_COASTING)) {
    ++counters_.refused;
    return {};
  }
  if (!plausible_utime(message->utime) || (seen && !(position.allFinite() && velocity.allFinite()))) {
    ++counters_.refused;
    return {};
  }
  if (!controller_.started()) return {};
  const auto next = controller_.next_tick();
  if (!target_run_.accepts(message->run, next)) {
    ++counters_.refused;
    return {};
  }
  if (followed != message->run) {
    targets_ = {};
    targets_.newly_lost(message->sequence, message->run);
  }
  if (!next && !seen) return {};  // the first target that is seen starts the ticks
  if (!named && !target_name_) target_name_ = message->name;
  if (!next || on_another_time_line(message->utime, *next)) controller_.restart_grid(message->utime);
  const bool taken =
      controller_.observe({.utime = message->utime,
                           .seen = seen,
                           .position = position,
                           .velocity = velocity,
                           .covariance = Eigen::Map<const Eigen::Matrix3d>(&message->covariance_m2[0][0]),
                           .orientation = orientation_of(*message)});
  if (!taken) {
    ++counters_.refused;
    return {Receipt::Effect::kConsumed, std::nullopt, message->sequence};  // it may have restarted the ticks
  }
  target_sequence_ = message->sequence;
  return {Receipt::Effect::kConsumed, message->utime, message->sequence};
}

Receipt ControllerNode::receive_obstacles(std::span<const uint8_t> bytes) {
  const auto message = decode_and_count<obstacles_t>(bytes);
  if (!message) return {};
  counters_.dropped += obstacles_.newly_lost(message->sequence);
  std::vector<controller::Obstacle> obstacles;
  for (const obstacle_t& sent : message->obstacles) {
    using Shape = controller::Obstacle::Shape;
    controller::Obstacle obstacle;
    const double* wxyz = sent.orientation_wxyz;
    const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    const bool known = sent.shape >= obstacle_t::SPHERE && sent.shape <= obstacle_t::BOX;
    // A quaternion that is not of unit length becomes NaN, which the controller refuses.
    obstacle.shape = sent.shape == obstacle_t::BOX       ? Shape::kBox
                     : sent.shape == obstacle_t::CAPSULE ? Shape::kCapsule
                                                         : Shape::kSphere;
    obstacle.X_WO.linear() = std::abs(q.norm() - 1) < 1e-3 ? q.normalized().toRotationMatrix()
                                                           : Eigen::Matrix3d::Constant(std::nan("")).eval();
    obstacle.X_WO.translation() = Eigen::Map<const Eigen::Vector3d>(sent.position_m);
    obstacle.size = known ? Eigen::Map<const Eigen::Vector3d>(sent.size_m).eval() : Eigen::Vector3d::Zero().eval();
    obstacles.push_back(obstacle);
  }
  new_obstacles_ = std::move(obstacles);
  obstacles_sequence_ = message->sequence;
  return {Receipt::Effect::kReplaces, std::nullopt, message->sequence};
}

Receipt ControllerNode::receive_choice(std::span<const uint8_t> bytes) {
  const auto message = decode_and_count<target_choice_t>(bytes);
  if (!message) return {};
  const bool known = message->kind >= target_choice_t::CONFIGURED && message->kind <= target_choice_t::NONE;
  if (!known || !choice_run_.accepts(message->run, controller_.next_tick())) {
    ++counters_.refused;
    return {};
  }
  if (message->kind != choice_.kind || message->name != choice_.name) {
    target_run_ = FollowedRun();
    controller_.expect_other_target();
    uncalibrated_ = false;
  }
  choice_ = *message;
  if (message->kind == target_choice_t::CONFIGURED) choice_run_ = FollowedRun(kChoiceSilence);
  if (message->kind == target_choice_t::NONE) controller_.stop_ticks();
  return {Receipt::Effect::kConsumed, std::nullopt, message->sequence};
}

Receipt ControllerNode::receive_bridge_state(std::span<const uint8_t> bytes) {
  const auto message = decode_and_count<bridge_state_t>(bytes);
  if (!message) return {};
  if (!bridge_run_.accepts(message->run, controller_.next_tick())) {
    ++counters_.refused;
    return {};
  }
  controller_.set_rate(message->setpoint_rate);
  start_again_ = message->far_run != 0 && message->far_run == run();
  return {started_again_ ? Receipt::Effect::kConsumed : Receipt::Effect::kReplaces};
}

Receipt ControllerNode::receive_robot_state(std::span<const uint8_t> bytes) {
  const auto message = decode_and_count<robot_state_t>(bytes);
  if (!message) return {};
  counters_.dropped += robot_states_.newly_lost(message->sequence, message->run);
  const bool running = controller_.next_tick().has_value();
  if (running && !start_again_ && controller_.options().feedback == controller::Feedback::kOpen) return {};
  const auto theta = from_fields(controller_.chain(), message->joint_name, message->joint_position);
  if (theta && robot_run_.accepts(message->run, controller_.next_tick()) &&
      (running && !start_again_ ? controller_.observe_robot(*theta) : controller_.start(*theta))) {
    robot_state_sequence_ = message->sequence;
    if (running && std::exchange(start_again_, false)) started_again_ = true;
    // The first measurement during the run must not replace the robot state from which the arm started.
    const bool first = started_again_ || (running && !measured_);
    measured_ = running;
    return {first ? Receipt::Effect::kConsumed : Receipt::Effect::kReplaces, std::nullopt, message->sequence};
  }
  ++counters_.refused;
  return {};
}

void ControllerNode::tick(Outbox& out) {
  if (new_obstacles_) {
    counters_.refused += controller_.set_obstacles(*new_obstacles_);
    new_obstacles_.reset();
  }
  started_again_ = false;
  last_ = controller_.tick();
  joint_setpoint_t setpoint;
  setpoint.utime = last_.utime;
  setpoint.sequence = sequence_;
  setpoint.run = run();
  setpoint.tick = last_.tick;
  setpoint.target_sequence = target_sequence_;
  setpoint.robot_state_sequence = robot_state_sequence_;
  setpoint.obstacles_sequence = obstacles_sequence_;
  setpoint.num_joints = controller_.chain().size();
  setpoint.joint_name = joint_names_;
  setpoint.joint_position = to_field(last_.theta);
  setpoint.joint_velocity = to_field(last_.velocity);
  send(out, channel::kJointSetpoint, setpoint);

  controller_state_t state;
  state.utime = last_.utime;
  state.sequence = sequence_++;
  state.tick = last_.tick;
  state.mode = static_cast<int8_t>(last_.mode);
  state.target_lost = last_.target_lost;
  state.target_unreachable = last_.target_unreachable;
  state.blocked = static_cast<int8_t>(last_.blocked);
  state.distance_m = last_.distance_m;
  Eigen::Map<Eigen::Vector3d>(state.hand_position_m) = last_.x;
  Eigen::Map<Eigen::Vector3d>(state.hand_target_m) = last_.x_T;
  state.gamma_rad2_m2 = last_.gamma;
  state.condition_number = last_.condition_number;
  state.attractor_residual_m = last_.attractor_residual_m;
  state.ik_searches = last_.ik_searches;
  state.num_joints = setpoint.num_joints;
  state.joint_name = joint_names_;
  state.joint_position = setpoint.joint_position;
  state.target_joint_position = to_field(last_.theta_target);
  state.weight_rad2_m2 = to_field(last_.weights);
  send(out, channel::kControllerState, state);
}

/// Which target is followed, where somebody has chosen it.
std::string ControllerNode::choice_text() const {
  if (choice_.kind == target_choice_t::CONFIGURED) return "";
  const std::string by = choice_.chosen_by.empty() ? "" : " by " + choice_.chosen_by;
  if (choice_.kind == target_choice_t::NONE) return ", without a target, as chosen" + by;
  return ", target '" + choice_.name + "' chosen" + by;
}

/// The joint that moves the link inside which the target seems to be; empty where it is in none.
std::string ControllerNode::joint_at_target() const {
  const auto* law = std::get_if<controller::GuardedParameters>(&controller_.options().law);
  const auto target = controller_.target_position();
  if (!law || !target || last_.target_lost) return "";
  const auto link = controller::link_at(controller_.chain(), law->body, last_.theta, *target);
  return link ? joint_names_[static_cast<size_t>(*link)] : "";
}

std::string ControllerNode::state() const {
  return reach_text() + choice_text();
}

std::string ControllerNode::reach_text() const {
  if (!controller_.started()) return "waiting for the robot";
  constexpr const char* kUncalibrated =
      "targets are refused: the camera pose is unknown (multireach-calibrate hand-eye)";
  if (!controller_.next_tick())
    return uncalibrated_ ? std::string("waiting for a target; ") + kUncalibrated : "waiting for a target";
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
    case controller::ReachMode::kNotStarted:
      text = "not started";
      break;
  }
  if (last_.interception)
    text += fmt::format(" the thrown target in {:.2f} s, {:.0f} mm from it as simulated",
                        std::max(0.0, 1e-6 * static_cast<double>(last_.interception->utime - last_.utime)),
                        1000 * last_.interception->error_m);
  if (last_.target_lost) text += ", target lost";
  if (uncalibrated_) text += std::string(", ") + kUncalibrated;
  if (last_.target_unreachable) text += ", target unreachable";
  if (const std::string joint = joint_at_target(); !joint.empty())
    text += fmt::format(
        ", the target is inside the arm, in the link after joint '{}': vision may track a part of the arm", joint);
  if (last_.target_flickers) text += ", target flickers between two positions: waiting until it stays";
  if (const char* why = blocked_text(last_.blocked); *why)
    text += fmt::format(", blocked {:.3f} m short: {}", last_.distance_m, why);
  return text;
}

}  // namespace multireach
