#include "robot_bridge/drivers/node/driver_node.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <multireach/bridge_state_t.hpp>
#include <utility>

#include "kinematics/default_limits.hpp"
#include "runtime/channels.hpp"
#include "runtime/joint_fields.hpp"

namespace multireach::drivers {
namespace {

constexpr double kImpossible = 1e6;       // rad or m, rad/s or m/s
constexpr double kLimitTolerance = 1e-6;  // rad or m
constexpr int64_t kMaxAge = 1000000;      // us, from images whose time is the wall clock's to their commands
constexpr int64_t kGone = 1000000;        // us: a bridge or robot that was not heard for so long
constexpr size_t kMostHeard = 16;
constexpr int64_t kBridgedTicks = 3;
constexpr int64_t kWaiting =
    1000000;                       // us, in which the messages are handled that waited while the program was stopped
constexpr int64_t kWaited = 3000;  // us: a command that is later than those before the stop by so much
constexpr const char* kFast = "refused commands that come faster than real time (was the bridge started with --speed?)";
constexpr double kStandstill = 0.01;  // of the speed limit, as in RobotMonitor

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
      joint_names_(joint_names(robot.chain)),
      follower_(limits_, options.command_timeout_us),
      pace_(options.command_timeout_us) {
  if (!options.simulated) return;
  WireOutbox wire;  // a driver that is enabled before it is connected has nothing to send yet
  driver_->enable(now(), wire);
}

void DriverNode::skip_ticks(int64_t ticks) {
  utime_ += ticks * kTickUs;
  if (ticks <= kBridgedTicks) return;
  follower_.hold(utime_);
  waiting_until_us_ = utime_ + kWaiting;
}

bool DriverNode::begin_end() {
  ending_ = true;
  follower_.stop();
  return true;
}

std::vector<std::string_view> DriverNode::inputs() const {
  std::vector<std::string_view> channels{channel::kJointCommand, channel::kBridgeRequest, channel::kBridgeState,
                                         channel::kRobotState};
  port_.append_inputs(channels);
  return channels;
}

Receipt DriverNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) {
  if (channel == channel::kJointCommand) {
    receive_command(bytes, out);
  } else if (channel == channel::kBridgeRequest) {
    receive_request(bytes, out);
  } else if (channel == channel::kBridgeState) {
    receive_bridge_state(bytes);
  } else if (channel == channel::kRobotState) {
    receive_robot_state(bytes);
  } else {
    ++counters_.received;
    port_.receive(channel, bytes, now(), out);
  }
  return {Receipt::Effect::kConsumed};
}

/// Whether a command's time is now: commands that follow from recorded images have another. The wall clock is asked
/// only where the commands begin, or their own time steps: a step of the clock must not end a motion.
bool DriverNode::is_of_now(const joint_command_t& command) const {
  if (options_.simulated || options_.accept_recorded) return true;
  const int64_t expected =
      follower_.following() ? commanded_utime_ + (utime_ - commanded_us_) : std::max<int64_t>(0, wall_clock_());
  return command.utime > expected - kMaxAge && command.utime < expected + kMaxAge;
}

/// Whether a command was sent while this program was stopped.
bool DriverNode::has_waited(const joint_command_t& command) const {
  if (utime_ >= waiting_until_us_ || commands_.sequence() < 0) return false;
  return command.utime - utime_ < commanded_utime_ - commanded_us_ - kWaited;
}

/// Why a command is refused; null when it is not.
const char* DriverNode::refusal_of(const joint_command_t& command, JointVector& position, JointVector& velocity) {
  if (const char* refusal = commands_.refusal_of(command, run(), utime_)) return refusal;
  const auto positions = from_fields(chain_, command.joint_name, command.joint_position);
  const auto velocities = from_fields(chain_, command.joint_name, command.joint_velocity);
  if (!is_valid(positions) || !is_valid(velocities) || !plausible_utime(command.utime))
    return "refused a command without a valid position and velocity for each joint";
  position = *positions;
  velocity = *velocities;
  if (chain_.limit_excess(position) > kLimitTolerance) return "refused a command beyond the joints' limits";
  if (driver_->status().phase != DriverStatus::Phase::kReady || !reading_)
    return "refused commands while the robot is not ready";
  if (command.run == fast_run_) return kFast;
  if (follower_.stopping() || ending_) return "refused commands while the arm decelerates";
  if (has_waited(command)) return "refused commands that waited while the driver was stopped";
  if (!is_of_now(command))
    return "refused commands whose time is not now, as they follow from recorded images (see --accept-recorded) or "
           "from a computer whose clock is wrong";
  // Also false where a reading is not a number.
  const bool near = ((position - reading_->position).array().abs() <= options_.max_start_distance).all();
  if (!follower_.following() && !near) return "refused commands that begin far from the arm";
  const bool at_standstill = !follower_.following() || (position == commanded_ && velocity.isZero(0));
  if (!pace_.is_ahead(command.utime, utime_, at_standstill)) return nullptr;
  if (pace_.often_ahead()) fast_run_ = command.run;
  return kFast;
}

void DriverNode::receive_command(std::span<const uint8_t> bytes, Outbox& out) {
  const auto command = decode_and_count<joint_command_t>(bytes);
  if (!command) return;
  JointVector position, velocity;
  const char* refusal = refusal_of(*command, position, velocity);
  counters_.dropped = commands_.missing();
  if (refusal) {
    ++counters_.refused;
    refusal_ = refusal;
    return;
  }
  commands_.obey(*command, utime_);
  waiting_until_us_ = 0;  // the next ones come after it
  const auto& state = follower_.command(position, velocity, command->utime, reading_->position, utime_);
  commanded_ = position;
  commanded_utime_ = command->utime;
  commanded_us_ = utime_;
  pass_on(state, command->utime, out);
}

/// The one place that commands the robot.
void DriverNode::pass_on(const robot_bridge::MotionState& state, int64_t utime, Outbox& out) {
  if (!state.position.allFinite() || !state.velocity.allFinite()) return;
  WireOutbox wire;
  driver_->command(state.position, state.velocity, utime, now(), wire);
  port_.send(wire, now(), out);
}

void DriverNode::receive_bridge_state(std::span<const uint8_t> bytes) {
  const auto state = decode_and_count<bridge_state_t>(bytes);
  if (state && (bridges_.size() < kMostHeard || bridges_.contains(state->run)))
    bridges_[state->run] = {utime_, state->robot_run};
}

void DriverNode::receive_robot_state(std::span<const uint8_t> bytes) {
  const auto state = decode_and_count<robot_state_t>(bytes);
  if (state && state->run != run() && (robots_.size() < kMostHeard || robots_.contains(state->run)))
    robots_[state->run] = {utime_, state->run};
}

/// A bridge that follows a robot which is there means that one. Before this driver's first ROBOT_STATE, and after a
/// restart, its bridge knows no robot or one that has gone.
bool DriverNode::means_this_robot(const Heard& bridge) const {
  return bridge.robot_run == run() || !robots_.contains(bridge.robot_run);
}

/// Why a request to enable or to reset is not obeyed; null when it is.
const char* DriverNode::refusal_of(const bridge_request_t& request) const {
  constexpr const char* kOther = "refused a request to another bridge";
  if (follower_.following()) return request.run == commands_.bridge_run() ? nullptr : kOther;
  const auto asked = bridges_.find(request.run);
  if (asked == bridges_.end() || !means_this_robot(asked->second)) return kOther;
  const auto meant = std::ranges::count_if(bridges_, [&](const auto& each) { return means_this_robot(each.second); });
  return meant > 1 ? "refused a request, as two bridges are running for this robot" : nullptr;
}

void DriverNode::receive_request(std::span<const uint8_t> bytes, Outbox& out) {
  const auto request = decode_and_count<bridge_request_t>(bytes);
  if (!request || (request->request != 0 && request->request == request_)) return;
  if (request->kind != bridge_request_t::ENABLE && request->kind != bridge_request_t::RESET) return;
  for (auto* heard : {&bridges_, &robots_})
    std::erase_if(*heard, [&](const auto& each) { return utime_ - each.second.us > kGone; });
  if (const char* refusal = refusal_of(*request)) {
    ++counters_.refused;
    refusal_ = refusal;
    return;
  }
  request_ = request->request;
  fast_run_.reset();
  WireOutbox wire;
  if (request->kind == bridge_request_t::ENABLE) {
    driver_->enable(now(), wire);
  } else {
    driver_->reset(now(), wire);
  }
  port_.send(wire, now(), out);
}

/// Once asked to end, when the arm is at standstill, or out of reach.
bool DriverNode::finished() const {
  if (!ending_ || follower_.following()) return false;
  if (!reading_ || driver_->status().phase != DriverStatus::Phase::kReady) return true;
  return (reading_->velocity.array().abs() <= kStandstill * limits_.velocity.array()).all();
}

/// Sends on where commands are missing.
void DriverNode::watch_commands(Outbox& out) {
  if (driver_->status().phase != DriverStatus::Phase::kReady) return follower_.hold(utime_);
  int64_t utime = 0;
  if (const auto* state = follower_.missing(utime_, utime)) pass_on(*state, utime, out);
}

/// The one place that makes a ROBOT_STATE.
void DriverNode::publish_reading(Outbox& out) {
  robot_state_t state{};
  state.utime = utime_;
  state.sequence = sequence_++;
  state.run = run();
  state.command_sequence = commands_.sequence();
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
  const RefusedMessages refused = driver_->refused();
  counters_.refused += refused.count - std::exchange(driver_refused_, refused.count);
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
  if (follower_.following()) text += follower_.stopping() ? ", decelerating" : ", following";
  if (!refusal_.empty()) text += ", " + refusal_;
  if (const RefusedMessages refused = driver_->refused(); refused.count > 0) text += "; " + refused.text;
  return text;
}

}  // namespace multireach::drivers
