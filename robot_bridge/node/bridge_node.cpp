#include "robot_bridge/node/bridge_node.hpp"

#include <multireach/bridge_request_t.hpp>
#include <multireach/bridge_state_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/config_keys.hpp"
#include "runtime/joint_fields.hpp"

namespace multireach {

namespace {

using robot_bridge::BridgeOptions;
using robot_bridge::BridgeState;
using robot_bridge::MeasurementVerdict;
using robot_bridge::SetpointVerdict;

constexpr int64_t kStatePeriod = 50;  // ticks from one BRIDGE_STATE to the next

ConfigKeys<BridgeOptions> bridge_keys() {
  using Shape = BridgeOptions::Shape;
  return ConfigKeys<BridgeOptions>("robot.yaml, section bridge", "The bridge. docs/safety.md tells what it promises.")
      .choice<Shape>(
          "shape", {{"smooth", Shape::kSmooth}, {"linear", Shape::kLinear}}, [](auto& o) -> auto& { return o.shape; },
          "`smooth`: the commands keep all limits, acceleration and jerk too; `linear`: as in the paper "
          "(Sect. 4), only position and speed limits, for simulated robots.")
      .number(
          "delay_ms", "ms", 0, 1000, [](auto& o) -> auto& { return o.delay_us; },
          "How late a set-point may arrive without affecting the motion.", 1e3)
      .number(
          "speed_where_unlimited", "rad/s or m/s", 1e-3, 1e3, [](auto& o) -> auto& { return o.speed_where_unlimited; },
          "Speed limit of joints for which the URDF gives none.")
      .number(
          "robot_timeout_ms", "ms", 1, 1000, [](auto& o) -> auto& { return o.robot_timeout_us; },
          "Without a command for this long, the robot stops by itself; after a longer gap in the commands the bridge "
          "waits for "
          "a ROBOT_STATE and for the robot to stand still.",
          1e3)
      .number(
          "max_setpoint_age_ms", "ms", 1, 1000, [](auto& o) -> auto& { return o.max_setpoint_age_us; },
          "An older set-point is refused.", 1e3)
      .number(
          "max_setpoint_lead_ms", "ms", 1, 1000, [](auto& o) -> auto& { return o.max_setpoint_lead_us; },
          "A set-point further in the future is refused.", 1e3)
      .number(
          "setpoint_timeout_ms", "ms", 100, 10000, [](auto& o) -> auto& { return o.setpoint_timeout_us; },
          "Without a set-point for this long, the bridge is ready to follow another controller.", 1e3)
      .number(
          "max_start_distance", "rad or m", 1e-3, 10, [](auto& o) -> auto& { return o.max_start_distance; },
          "Largest distance of a controller's first set-point from the robot, in each joint.")
      .number(
          "max_tracking_error", "rad or m", 1e-3, 10, [](auto& o) -> auto& { return o.monitor.max_tracking_error; },
          "A joint that is measured further than this from its commands of the last 100 ms is a fault; beyond half "
          "of it the motion slows down.")
      .number(
          "state_timeout_ms", "ms", 10, 10000, [](auto& o) -> auto& { return o.monitor.state_timeout_us; },
          "Without a ROBOT_STATE for this long, the motion stops until there is one.", 1e3)
      .number(
          "robot_lost_ms", "ms", 10, 100000, [](auto& o) -> auto& { return o.monitor.robot_lost_us; },
          "Without a ROBOT_STATE for this long, the bridge is in a fault.", 1e3);
}

}  // namespace

BridgeOptions bridge_options_from(const RobotConfig& robot) {
  BridgeOptions options;
  options.setpoint_period_us = robot.tick_us;
  const auto section = robot.section("bridge");
  if (section) bridge_keys().read(*section, options);
  const int64_t longest_us = 3 * options.setpoint_period_us;
  if (options.delay_us > longest_us && section && section->has("delay_ms"))
    section->fail("delay_ms",
                  "at most " + config_number(static_cast<double>(longest_us) * 1e-3) + ", three times tick_ms");
  if (options.delay_us > longest_us) {
    robot.file.fail("tick_ms", "at least " + config_number(static_cast<double>(options.delay_us) * 1e-3 / 3) +
                                   ", a third of the bridge's delay_ms");
  }
  options.acceleration = robot.joint_acceleration_limits;
  options.jerk = robot.joint_jerk_limits;
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
  return {channel::kJointSetpoint, channel::kRobotState, channel::kBridgeRequest};
}

Receipt BridgeNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) {
  if (channel == channel::kJointSetpoint) return receive_setpoint(bytes, out);
  if (channel == channel::kRobotState) return receive_robot_state(bytes, out);
  if (channel == channel::kBridgeRequest) return receive_request(bytes, out);
  throw unknown_input(channel);
}

Receipt BridgeNode::receive_robot_state(std::span<const uint8_t> bytes, Outbox& out) {
  const robot_state_t* message = &robot_state_;
  if (!decode_and_count(bytes, robot_state_)) return {};
  const auto theta = from_fields(chain_, message->joint_name, message->joint_position);
  const auto velocity = from_fields(chain_, message->joint_name, message->joint_velocity);
  const auto followed = bridge_.followed_robot();
  auto verdict = MeasurementVerdict::kInvalid;
  const bool taken = theta && velocity && plausible_utime(message->utime) &&
                     bridge_.measured({.run = message->run,
                                       .utime = message->utime,
                                       .theta = *theta,
                                       .velocity = *velocity,
                                       .real = !message->simulated,
                                       .faulted = !message->fault.empty()},
                                      verdict);
  if (taken || verdict == MeasurementVerdict::kOlder)
    counters_.dropped += robot_states_.newly_lost(message->sequence, message->run);
  if (!taken) {
    ++counters_.refused;
    const int64_t count = ++refused_states_[static_cast<size_t>(verdict)];
    if (verdict != MeasurementVerdict::kOtherRobot) return {};
    // Many of them are followed: each counts. While no commands are sent, something must carry their record.
    if (count % kStatePeriod == 0) send_state(out);
    return {Receipt::Effect::kConsumed, std::nullopt, message->sequence};
  }
  robot_state_sequence_ = message->sequence;
  if (!message->fault.empty()) robot_fault_ = message->fault;
  const bool replaces = !bridge_.next_tick() && (!followed || *followed == message->run);
  return {replaces ? Receipt::Effect::kReplaces : Receipt::Effect::kConsumed, std::nullopt, message->sequence};
}

Receipt BridgeNode::receive_setpoint(std::span<const uint8_t> bytes, Outbox& out) {
  const joint_setpoint_t* message = &setpoint_;
  if (!decode_and_count(bytes, setpoint_)) return {};
  const auto theta = from_fields(chain_, message->joint_name, message->joint_position);
  const auto velocity = from_fields(chain_, message->joint_name, message->joint_velocity);
  bool restarted = false;
  const SetpointVerdict verdict = theta && velocity && plausible_utime(message->utime)
                                      ? bridge_.setpoint({.run = message->run,
                                                          .utime = message->utime,
                                                          .sequence = message->sequence,
                                                          .theta = *theta,
                                                          .velocity = *velocity},
                                                         restarted)
                                      : SetpointVerdict::kInvalid;
  ++verdicts_[static_cast<size_t>(verdict)];
  // Also one that comes too late was not lost.
  if (verdict != SetpointVerdict::kOtherRun && verdict != SetpointVerdict::kInvalid)
    counters_.dropped += setpoints_.newly_lost(message->sequence, message->run);
  if (verdict != SetpointVerdict::kAccepted) {
    ++counters_.refused;
    // Many that are mistimed end the motion.
    if (verdict == SetpointVerdict::kTooOld || verdict == SetpointVerdict::kTooEarly)
      return {Receipt::Effect::kConsumed, std::nullopt, message->sequence};
    if (verdict != SetpointVerdict::kFarFromRobot) return {};
    far_run_ = message->run;
    send_state(out);
    return {Receipt::Effect::kConsumed, std::nullopt, message->sequence};
  }
  far_run_ = 0;
  return {Receipt::Effect::kConsumed, message->utime, message->sequence, restarted};
}

Receipt BridgeNode::receive_request(std::span<const uint8_t> bytes, Outbox& out) {
  const auto message = decode_and_count<bridge_request_t>(bytes);
  if (!message) return {};
  // A request in an old log, or for another bridge, changes nothing; but whoever asks to stop means every bridge.
  const bool stops = message->kind == bridge_request_t::DISABLE || message->kind == bridge_request_t::PAUSE;
  const bool meant = message->run == run() || (stops && message->run == bridge_request_t::ALL);
  if (message->kind != bridge_request_t::STATUS && !meant) {
    ++counters_.refused;
    return {};
  }
  if (message->request != 0 && message->request == request_) {  // sent again because the answer was lost
    send_state(out);
    return {Receipt::Effect::kConsumed};
  }
  request_ = message->request;
  request_accepted_ = true;
  switch (message->kind) {
    case bridge_request_t::ENABLE:
      bridge_.enable();
      break;
    case bridge_request_t::DISABLE:
      bridge_.disable();
      break;
    case bridge_request_t::SPEED:
      request_accepted_ = message->speed >= 0 && message->speed <= 1;
      bridge_.set_speed(message->speed);
      break;
    case bridge_request_t::PAUSE:
    case bridge_request_t::RESUME:
      bridge_.pause(message->kind == bridge_request_t::PAUSE);
      break;
    case bridge_request_t::RESET:
      request_accepted_ = bridge_.reset();
      break;
    case bridge_request_t::STATUS:
      break;
    default:
      request_accepted_ = false;
  }
  send_state(out);
  return {Receipt::Effect::kConsumed};
}

std::optional<OutMessage> BridgeNode::shutdown_request() const {
  bridge_request_t request{};
  request.kind = bridge_request_t::DISABLE;
  request.run = run();
  auto bytes = encode(request);
  if (!bytes) return std::nullopt;
  return OutMessage{channel::kBridgeRequest, std::move(*bytes)};
}

/// States of the robot that the recorder lost had arrived at the bridge. Most inputs are such states, so an unknown one
/// counts as one.
void BridgeNode::skip_inputs(int64_t inputs, std::string_view channel) {
  if (!channel.empty() && channel != channel::kRobotState) return;
  bridge_.heard();
  robot_state_sequence_ += inputs;
}

void BridgeNode::tick(Outbox& out) {
  last_ = bridge_.tick();
  if (last_.limited) ++counters_.limited;
  command_.utime = last_.utime;
  command_.sequence = sequence_++;
  command_.run = run();
  command_.robot_run = bridge_.robot_run();
  command_.setpoint_sequence = last_.setpoint_sequence;
  command_.robot_state_sequence = robot_state_sequence_;
  command_.holding = last_.holding;
  command_.limited = last_.limited;
  command_.joint_position.assign(last_.theta.begin(), last_.theta.end());
  command_.joint_velocity.assign(last_.velocity.begin(), last_.velocity.end());
  send(out, channel::kJointCommand, command_);
  if (command_.sequence % kStatePeriod == 0 || !bridge_.next_tick()) send_state(out);
}

void BridgeNode::send_state(Outbox& out) {
  bridge_state_t state{};
  state.utime = last_.utime;
  state.sequence = sequence_ - 1;
  state.run = run();
  state.robot_run = bridge_.next_tick() ? bridge_.robot_run() : bridge_.followed_robot().value_or(0);
  state.state = static_cast<int8_t>(bridge_.state());
  state.cause = cause();
  state.path_rate = bridge_.path_rate();
  state.setpoint_rate = bridge_.setpoint_rate();
  state.speed = bridge_.speed();
  state.far_run = far_run_;
  state.request = request_;
  state.request_accepted = request_accepted_;
  send(out, channel::kBridgeState, state);
}

/// The cause of the bridge's state; where the robot itself reports a fault, or did so, its fault text.
std::string BridgeNode::cause() const {
  const bool idle = bridge_.state() == BridgeState::kIdle;
  const bool stands_still = idle || bridge_.state() == BridgeState::kFault;
  const bool robots_own =
      stands_still && (bridge_.robot_faulted() || std::string_view(bridge_.cause()) == robot_bridge::kRobotsOwnFault);
  if (robots_own && !robot_fault_.empty()) return "the robot reports: " + robot_fault_;
  if (idle) return bridge_.enabled() ? "waiting for the robot" : "disabled";
  if (bridge_.state() == BridgeState::kArmed && !bridge_.commands_robot())
    return "shape: linear never commands a real robot";
  if (std::string_view(bridge_.cause()) == robot_bridge::kDoesNotFollow)
    return std::string(bridge_.cause()) + " (joint '" + chain_.joint(bridge_.joint_of_fault()).name + "')";
  const bool may_move = bridge_.state() == BridgeState::kArmed || bridge_.state() == BridgeState::kRunning;
  if (may_move && bridge_.paused()) return "paused";
  if (may_move && bridge_.speed() < robot_bridge::Bridge::kMinSpeed) return "the speed override is 0";
  return bridge_.cause();
}

std::string BridgeNode::state() const {
  std::string text = name_of(bridge_.state());
  if (const std::string why = cause(); !why.empty()) {
    text += ": " + why;
  } else if (bridge_.state() == BridgeState::kArmed) {
    text += ": waiting for a set-point";
  } else if (last_.holding) {
    text += ", holding";
  }
  std::string refused;
  for (size_t k = 1; k < verdicts_.size(); ++k) {
    if (verdicts_[k] == 0) continue;
    refused += refused.empty() ? "; set-points refused: " : ", ";
    refused += std::to_string(verdicts_[k]) + " " + name_of(static_cast<SetpointVerdict>(k));
  }
  static constexpr std::array kCauses{"", "invalid", "older than the last", "of another robot"};
  std::string states;
  for (size_t k = 1; k < refused_states_.size(); ++k) {
    if (refused_states_[k] == 0) continue;
    states += states.empty() ? "; robot states refused: " : ", ";
    states += std::to_string(refused_states_[k]) + " " + kCauses[k];
  }
  refused += states;
  return text + refused;
}

}  // namespace multireach
