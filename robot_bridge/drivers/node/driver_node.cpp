#include "robot_bridge/drivers/node/driver_node.hpp"

#include <spdlog/spdlog.h>

#include <cstdlib>
#include <multireach/bridge_request_t.hpp>

#include "kinematics/default_limits.hpp"
#include "runtime/channels.hpp"
#include "runtime/joint_fields.hpp"

namespace multireach::drivers {
namespace {

constexpr double kImpossible = 1e6;       // rad or m, rad/s or m/s
constexpr double kLimitTolerance = 1e-6;  // rad or m
constexpr int64_t kMaxAge = 1000000;      // us, from images whose time is the wall clock's to their commands

bool is_valid(const std::optional<JointVector>& values) {
  return values && values->allFinite() && values->cwiseAbs().maxCoeff() < kImpossible;
}

}  // namespace

DriverNode::DriverNode(const RobotConfig& robot, std::unique_ptr<Driver> driver, Transports transports,
                       const DriverNodeOptions& options, std::function<int64_t()> wall_clock)
    : chain_(robot.chain),
      limits_(robot_bridge::motion_limits(robot.chain, kSpeedWhereUnlimited, robot.joint_acceleration_limits,
                                          robot.joint_jerk_limits)),
      driver_(std::move(driver)),
      port_(*driver_, std::move(transports)),
      options_(options),
      wall_clock_(std::move(wall_clock)),
      state_period_us_(robot.state_period_us),
      joint_names_(joint_names(robot.chain)) {
  if (!options.simulated) return;
  WireOutbox wire;  // a driver that is enabled before it is connected has nothing to send yet
  driver_->enable(now(), wire);
}

std::vector<std::string_view> DriverNode::inputs() const {
  std::vector<std::string_view> channels{channel::kJointCommand, channel::kBridgeRequest};
  port_.append_inputs(channels);
  return channels;
}

Receipt DriverNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) {
  if (channel == channel::kJointCommand) {
    receive_command(bytes, out);
  } else if (channel == channel::kBridgeRequest) {
    receive_request(bytes, out);
  } else {
    ++counters_.received;
    port_.receive(channel, bytes, now(), out);
  }
  return {Receipt::Effect::kConsumed};
}

/// Why a command of the followed bridge is refused; null when it is not.
const char* DriverNode::fault_of(const joint_command_t& command, JointVector& position, JointVector& velocity) const {
  const auto positions = from_fields(chain_, command.joint_name, command.joint_position);
  const auto velocities = from_fields(chain_, command.joint_name, command.joint_velocity);
  if (!is_valid(positions) || !is_valid(velocities) || !plausible_utime(command.utime))
    return "refused a command without a valid position and velocity for each joint";
  position = *positions;
  velocity = *velocities;
  if (chain_.limit_excess(position) > kLimitTolerance) return "refused a command beyond the joints' limits";
  if (driver_->status().phase != DriverStatus::Phase::kReady || !reading_)
    return "refused commands while the robot is not ready";
  if (ramp_) return "refused commands while the arm decelerates";
  if (!options_.simulated && !options_.accept_recorded && std::abs(command.utime - now().wall_us) > kMaxAge)
    return "refused commands whose time is not now, as they follow from recorded images (see --accept-recorded) or "
           "from a computer whose clock is wrong";
  if (!commanded_ && (position - reading_->position).cwiseAbs().maxCoeff() > options_.max_start_distance)
    return "refused commands that begin far from the arm";
  return nullptr;
}

void DriverNode::receive_command(std::span<const uint8_t> bytes, Outbox& out) {
  const auto command = decode_and_count<joint_command_t>(bytes);
  if (!command) return;
  const bool accepted = commands_.accepts(*command, run(), utime_);
  counters_.dropped = commands_.missing();
  JointVector position, velocity;
  const char* refusal = accepted ? fault_of(*command, position, velocity) : commands_.refusal();
  if (refusal) {
    ++counters_.refused;
    refusal_ = refusal;
    return;
  }
  if (!commanded_) blend_.emplace(limits_, reading_->position - position, command->utime);
  if (blend_) blend_->apply(command->utime, position, velocity);
  if (blend_ && blend_->over(command->utime)) blend_.reset();
  const double seconds = static_cast<double>(command->utime - commanded_utime_) * 1e-6;
  JointVector acceleration = JointVector::Zero(chain_.size());
  if (commanded_ && seconds > 0 && seconds < 0.01) {
    acceleration = ((velocity - commanded_->velocity) / seconds).cwiseMax(-limits_.acceleration);
    acceleration = acceleration.cwiseMin(limits_.acceleration).eval();
  }
  commanded_ = robot_bridge::MotionState{position, velocity, acceleration};
  commanded_utime_ = command->utime;
  commanded_us_ = utime_;
  command_sequence_ = command->sequence;
  WireOutbox wire;
  driver_->command(position, velocity, command->utime, now(), wire);
  port_.send(wire, now(), out);
}

void DriverNode::receive_request(std::span<const uint8_t> bytes, Outbox& out) {
  const auto request = decode_and_count<bridge_request_t>(bytes);
  if (!request || (request->request != 0 && request->request == request_)) return;
  const bool other_bridge = commanded_ && request->run != commands_.bridge_run();
  if (other_bridge || (request->kind != bridge_request_t::ENABLE && request->kind != bridge_request_t::RESET)) return;
  request_ = request->request;
  WireOutbox wire;
  if (request->kind == bridge_request_t::ENABLE) {
    driver_->enable(now(), wire);
  } else {
    driver_->reset(now(), wire);
  }
  port_.send(wire, now(), out);
}

/// Decelerates the arm when its commands end.
void DriverNode::watch_commands(Outbox& out) {
  if (driver_->status().phase != DriverStatus::Phase::kReady) {
    commanded_.reset();
    ramp_.reset();
    return;
  }
  if (!commanded_ || utime_ - commanded_us_ <= options_.command_timeout_us) return;
  if (!ramp_) {
    ramp_.emplace(limits_, *commanded_);
    commanded_us_ = utime_ - options_.command_timeout_us - kTickUs;
  }
  const int64_t elapsed = utime_ - commanded_us_ - options_.command_timeout_us;
  const robot_bridge::MotionState& state = ramp_->at(static_cast<double>(elapsed) * 1e-6);
  WireOutbox wire;
  driver_->command(state.position, state.velocity, commanded_utime_ + elapsed, now(), wire);
  port_.send(wire, now(), out);
  if (!ramp_->at_rest()) return;
  ramp_.reset();
  commanded_.reset();
}

/// The one place that makes a ROBOT_STATE.
void DriverNode::publish_reading(Outbox& out) {
  robot_state_t state{};
  state.utime = utime_;
  state.sequence = sequence_++;
  state.run = run();
  state.command_sequence = command_sequence_;
  state.simulated = options_.simulated;
  const DriverStatus status = driver_->status();
  if (status.phase == DriverStatus::Phase::kFault) state.fault = status.text;
  state.num_joints = chain_.size();
  state.joint_name = joint_names_;
  state.joint_position = to_field(reading_->position);
  state.joint_velocity = to_field(reading_->velocity);
  state.joint_effort = to_field(reading_->effort);
  send(out, channel::kRobotState, state);
  published_us_ = utime_;
}

void DriverNode::tick(Outbox& out) {
  port_.tick(now(), out);
  watch_commands(out);
  bool fresh = false;
  if (auto reading = driver_->take_reading()) {
    reading_ = std::move(reading);
    fresh = true;
  }
  // Without ROBOT_STATE the bridge decelerates, and then waits: a robot that does not obey must be silent, or say why.
  const bool ready = driver_->status().phase != DriverStatus::Phase::kWaiting;
  const bool due = utime_ - published_us_ + kTickUs >= state_period_us_;  // a reading may be a tick early
  if (ready && fresh && due) publish_reading(out);
  report_status();
  utime_ += kTickUs;
}

void DriverNode::report_status() {
  const DriverStatus status = driver_->status();
  if (status.text == reported_) return;
  reported_ = status.text;
  if (status.phase == DriverStatus::Phase::kFault) {
    spdlog::warn("the robot: {}", status.text);
  } else {
    spdlog::info("the robot: {}", status.text);
  }
}

std::string DriverNode::state() const {
  const DriverStatus status = driver_->status();
  std::string text = status.phase == DriverStatus::Phase::kFault ? "fault: " + status.text : status.text;
  if (commanded_) text += ramp_ ? ", decelerating" : ", following";
  if (!refusal_.empty()) text += ", " + refusal_;
  return text;
}

}  // namespace multireach::drivers
