#pragma once

#include <spdlog/spdlog.h>

#include <algorithm>
#include <deque>
#include <multireach/bridge_request_t.hpp>
#include <multireach/bridge_state_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <numbers>

#include "numeric/random.hpp"
#include "robot_bridge/drivers/emulators/emulator_node.hpp"
#include "robot_bridge/node/bridge_node.hpp"
#include "runtime/channels.hpp"
#include "runtime/joint_fields.hpp"

namespace multireach::testing {

/// Faults of the connection between driver and emulator.
struct WireFaults {
  bool cut = false;       ///< nothing passes; a stream is closed
  int64_t delay_ms = 0;   ///< of everything
  double loss = 0;        ///< share of the LCM messages that are lost
  double corruption = 0;  ///< share of the chunks of a serial line in which one byte is changed
  int64_t lost = 0;       ///< messages lost so far
  CounterRandom random{1};
  uint64_t counter = 0;

  bool happens(double share) { return share > 0 && random.uniform(counter++, 0, 1) < share; }
};

/// One direction of a stream in memory.
struct Stream {
  std::deque<std::pair<int64_t, std::vector<uint8_t>>> chunks;  // due times, milliseconds
  int hang_ups = 0;                                             // of the sender
};

/// A stream in memory, in virtual time.
class MemoryTransport : public drivers::Transport {
 public:
  MemoryTransport(std::shared_ptr<Stream> in, std::shared_ptr<Stream> out, const int64_t& now_ms, WireFaults& faults,
                  bool serial)
      : in_(std::move(in)), out_(std::move(out)), now_ms_(&now_ms), faults_(&faults), serial_(serial) {}

  bool open(int64_t) override {
    if (!faults_->cut && !open_) {
      hang_ups_ = in_->hang_ups;
      open_ = true;
    }
    return open_;
  }
  bool receive(std::vector<uint8_t>& bytes) override {
    if (!serial_ && (faults_->cut || in_->hang_ups != hang_ups_)) return false;
    for (; !in_->chunks.empty() && in_->chunks.front().first <= *now_ms_; in_->chunks.pop_front()) {
      const auto& chunk = in_->chunks.front().second;
      bytes.insert(bytes.end(), chunk.begin(), chunk.end());
    }
    return true;
  }
  bool send(std::span<const uint8_t> bytes) override {
    if (faults_->cut) return serial_;
    out_->chunks.emplace_back(*now_ms_ + faults_->delay_ms, std::vector<uint8_t>(bytes.begin(), bytes.end()));
    auto& chunk = out_->chunks.back().second;
    if (serial_ && !chunk.empty() && faults_->happens(faults_->corruption)) {
      chunk[faults_->counter % chunk.size()] ^= 0x10;
      ++faults_->lost;
    }
    return true;
  }
  void close() override {
    open_ = false;
    ++out_->hang_ups;
    in_->chunks.clear();
    out_->chunks.clear();
  }

 private:
  std::shared_ptr<Stream> in_, out_;
  int hang_ups_ = 0;
  const int64_t* now_ms_;
  WireFaults* faults_;
  bool serial_, open_ = false;
};

/// How fast and how hard what a driver commands is, as shares of the limits of robot.yaml: one sample in each
/// millisecond, over every uninterrupted stretch of them.
class CommandCheck {
 public:
  explicit CommandCheck(const RobotConfig& robot)
      : limits_(robot_bridge::motion_limits(robot.chain, 1, robot.joint_acceleration_limits, robot.joint_jerk_limits)) {
  }

  void commanded(const JointVector& position) { newest_ = position; }
  void end_millisecond() {
    check_step();
    if (!newest_) {
      samples_.clear();
      return;
    }
    samples_.push_back(*std::exchange(newest_, std::nullopt));
    if (samples_.size() > 3) samples_.pop_front();
    const size_t n = samples_.size();
    if (n < 2) return;
    const JointVector speed = (samples_[n - 1] - samples_[n - 2]) * 1e3;
    fastest = std::max(fastest, speed.cwiseAbs().cwiseQuotient(limits_.velocity).maxCoeff());
    if (n < 3) return;
    const JointVector acceleration = (samples_[2] - 2 * samples_[1] + samples_[0]) * 1e6;
    hardest = std::max(hardest, acceleration.cwiseAbs().cwiseQuotient(limits_.acceleration).maxCoeff());
  }

  /// A millisecond in which the driver is stopped.
  void pass_millisecond() { ++since_sent_ms_; }
  /// The robot has got no position for some milliseconds, and rests at the last.
  void rest() {
    if (samples_.empty()) return;
    samples_.assign(3, samples_.back());
  }

  double fastest = 0, hardest = 0;
  double largest_step = 0;  ///< as `fastest`, also across gaps, in which the robot rests at the last position

 private:
  static constexpr int64_t kBridged = 3, kForgotten = 500;  // ms without a command

  void check_step() {
    ++since_sent_ms_;
    if (!newest_) return;
    if (sent_.size() > 0 && since_sent_ms_ < kForgotten) {
      const double periods = since_sent_ms_ <= kBridged + 1 ? static_cast<double>(since_sent_ms_) : 1;
      const JointVector speed = (*newest_ - sent_) * 1e3 / periods;
      largest_step = std::max(largest_step, speed.cwiseAbs().cwiseQuotient(limits_.velocity).maxCoeff());
    }
    sent_ = *newest_;
    since_sent_ms_ = 0;
  }

  JointVector sent_;
  int64_t since_sent_ms_ = 0;
  robot_bridge::MotionLimits limits_;
  std::deque<JointVector> samples_;
  std::optional<JointVector> newest_;
};

/// Passes everything on to a driver, and the commands also to a check.
class CheckedDriver : public drivers::Driver {
 public:
  CheckedDriver(std::unique_ptr<drivers::Driver> driver, CommandCheck& check)
      : driver_(std::move(driver)), check_(&check) {}

  std::vector<drivers::Link> links() const override { return driver_->links(); }
  void link_changed(size_t link, bool up, const drivers::Time& now, drivers::WireOutbox& out) override {
    driver_->link_changed(link, up, now, out);
  }
  void receive(size_t link, std::span<const uint8_t> bytes, const drivers::Time& now,
               drivers::WireOutbox& out) override {
    driver_->receive(link, bytes, now, out);
  }
  void tick(const drivers::Time& now, drivers::WireOutbox& out) override { driver_->tick(now, out); }
  void command(const JointVector& position, const JointVector& velocity, int64_t utime, const drivers::Time& now,
               drivers::WireOutbox& out) override {
    check_->commanded(position);
    driver_->command(position, velocity, utime, now, out);
  }
  void enable(const drivers::Time& now, drivers::WireOutbox& out) override { driver_->enable(now, out); }
  void reset(const drivers::Time& now, drivers::WireOutbox& out) override { driver_->reset(now, out); }
  std::optional<drivers::Reading> take_reading() override { return driver_->take_reading(); }
  drivers::DriverStatus status() const override { return driver_->status(); }
  drivers::RefusedMessages refused() const override { return driver_->refused(); }

 private:
  std::unique_ptr<drivers::Driver> driver_;
  CommandCheck* check_;
};

/// Bridge, driver and emulator in one thread and in virtual time, with a sender of set-points that moves all joints to
/// and fro.
class DriverLoop {
 public:
  explicit DriverLoop(const RobotConfig& robot, const std::string& name = "",
                      const drivers::DriverNodeOptions& options = {})
      : commands(robot), robot_(robot), bridge_(robot) {
    spdlog::set_level(spdlog::level::err);
    auto config = drivers::driver_config_from(robot, name);
    std::unique_ptr<drivers::Driver> driver =
        std::make_unique<CheckedDriver>(drivers::make_driver(robot, config), commands);
    auto emulated = drivers::make_emulator(robot, config);
    drivers::Transports driver_side, emulator_side;
    for (const drivers::Link& link : driver->links()) {
      if (link.kind == drivers::Link::Kind::kLcm) {
        lcm_.push_back(link.send);
        lcm_.push_back(link.receive);
        driver_side.push_back(nullptr);
        emulator_side.push_back(nullptr);
        continue;
      }
      const bool serial = link.kind == drivers::Link::Kind::kSerial;
      auto to_robot = std::make_shared<Stream>(), from_robot = std::make_shared<Stream>();
      driver_side.push_back(std::make_unique<MemoryTransport>(from_robot, to_robot, now_ms_, faults, serial));
      emulator_side.push_back(std::make_unique<MemoryTransport>(to_robot, from_robot, now_ms_, faults, serial));
    }
    const auto driver_wall = [this] { return kWallOrigin + now_ms_ * 1000 + driver_clock_error_us; };
    const auto robot_wall = [this] { return kWallOrigin + now_ms_ * 1000 + robot_clock_error_us; };
    auto node_options = options;
    node_options.simulated = true;
    node_options.command_timeout_us = config.node.command_timeout_us;
    node_options.max_start_distance = config.node.max_start_distance;
    driver_ = std::make_unique<drivers::DriverNode>(robot, std::move(driver), std::move(driver_side), node_options,
                                                    driver_wall);
    emulator_ = std::make_unique<drivers::EmulatorNode>(std::move(emulated), std::move(emulator_side), robot_wall);
    previous_ = emulator().position();
  }

  /// Lets `ms` milliseconds pass.
  void run(int64_t ms) {
    for (const int64_t end = now_ms_ + ms; now_ms_ < end; ++now_ms_) {
      deliver_due();
      if (sends_setpoints && now_ms_ % 50 == 0) send_setpoint();
      while (bridge_.next_tick() && *bridge_.next_tick() <= now_ms_ * 1000) {
        if (bridge_stalls) {
          bridge_.skip_ticks(1);
          continue;
        }
        Outbox out;
        bridge_.tick(out);
        route(out);
      }
      Outbox out;
      if (now_ms_ < driver_stalled_until_ms) {
        ++driver_missed_;
      } else {
        resume_driver(out);
        driver_->tick(out);
      }
      emulator_->tick(out);
      route(out);
      if (driver_missed_ == 0) {
        commands.end_millisecond();
      } else {
        commands.pass_millisecond();
      }
      const JointVector& q = emulator().position();
      const JointVector speed = (q - previous_) * 1e3;
      fastest_share = std::max(fastest_share, (speed.array().abs() / robot_.chain.velocity().array()).maxCoeff());
      previous_ = q;
    }
  }

  /// The user runs `multireach-robot KIND`. Returns whether the bridge accepted.
  bool ask(int8_t kind) {
    bridge_request_t request{};
    request.kind = kind;
    request.run = Node::kVirtualRun;
    request.request = ++requests_;
    Outbox out{{channel::kBridgeRequest, *encode(request)}};
    route(out);
    return bridge_state.request == requests_ && bridge_state.request_accepted;
  }

  /// The controller is restarted: its set-points begin where the arm is.
  void restart_controller() {
    ++setpoint_run_;
    setpoint_origin_.reset();
  }

  /// What a person does after a fault, as docs/robots.md says: the robot is restarted at its pendant where it must be,
  /// `multireach-robot reset` until the bridge accepts, and the controller is restarted.
  bool recover() {
    run(std::max<int64_t>(0, driver_stalled_until_ms - now_ms_));
    while (!waiting_.empty()) run(1);
    faults = WireFaults{};
    command_loss = 0;
    sends_setpoints = bridge_stalls = false;
    emulator().restart();
    run(1000);
    ask(bridge_request_t::ENABLE);
    bool accepted = false;
    for (int attempt = 0; attempt < 10 && !accepted; ++attempt) {
      run(3000);
      ask(bridge_request_t::STATUS);
      accepted = bridge_state.state != bridge_state_t::FAULT || ask(bridge_request_t::RESET);
      if (!accepted && attempt % 2 == 0) ask(bridge_request_t::RESET);
    }
    run(7000);  // a driver that could only now recover the robot
    restart_controller();
    sends_setpoints = true;
    run(2000);
    ask(bridge_request_t::STATUS);
    return bridge_state.state == bridge_state_t::RUNNING;
  }

  /// Another process on the LCM group sends this.
  void inject(std::string_view channel, const std::vector<uint8_t>& bytes) { pass({channel, bytes}); }

  drivers::Emulator& emulator() { return emulator_->emulator(); }
  drivers::DriverNode& driver() { return *driver_; }
  BridgeNode& bridge() { return bridge_; }
  int64_t now_ms() const { return now_ms_; }
  const RobotConfig& robot() const { return robot_; }

  WireFaults faults;
  bool sends_setpoints = true, bridge_stalls = false;
  int64_t driver_clock_error_us = 0, robot_clock_error_us = 0;  ///< of the wall clocks of their computers
  CommandCheck commands;                                        ///< of the driver to its robot
  double command_loss = 0;              ///< share of the bridge's commands that the network loses
  int64_t commands_held_until_ms = 0;   ///< the network delivers none of the bridge's commands
  int64_t driver_stalled_until_ms = 0;  ///< its process is stopped; messages to it wait
  double fastest_share = 0;             ///< largest measured joint speed, as a share of the robot.yaml's limits
  bridge_state_t bridge_state{};
  std::vector<robot_state_t> robot_states;  ///< all
  std::vector<std::pair<int64_t, std::vector<uint8_t>>>
      commands_sent;  ///< LCM messages of the driver, with times in ms
  bool keep_messages = false;

 private:
  static constexpr int64_t kWallOrigin = 1700000000000000;

  void send_setpoint() {
    if (!measured_) return;
    if (!setpoint_origin_) {
      setpoint_origin_ = measured_;
      setpoint_start_ms_ = now_ms_;
      setpoint_sequence_ = 0;
    }
    // A cosine whose speed stays below half of each joint's limit, towards the middle of the joint's range.
    constexpr double kPeriod = 4;  // s
    const double w = 2 * std::numbers::pi / kPeriod;
    const double t = static_cast<double>(now_ms_ - setpoint_start_ms_) * 1e-3;
    joint_setpoint_t setpoint{};
    setpoint.utime = now_ms_ * 1000;
    setpoint.sequence = setpoint_sequence_++;
    setpoint.run = setpoint_run_;
    setpoint.num_joints = robot_.chain.size();
    setpoint.joint_name = joint_names(robot_.chain);
    for (int i = 0; i < robot_.chain.size(); ++i) {
      const double middle = 0.5 * (robot_.chain.sample_lower(i) + robot_.chain.sample_upper(i));
      const double amplitude = std::min(0.4 * robot_.chain.velocity()[i] / w, 0.3) * 0.5;
      const double side = (*setpoint_origin_)[i] > middle ? -1 : 1;
      setpoint.joint_position.push_back((*setpoint_origin_)[i] + side * amplitude * (1 - std::cos(w * t)));
      setpoint.joint_velocity.push_back(side * amplitude * w * std::sin(w * t));
    }
    Outbox out{{channel::kJointSetpoint, *encode(setpoint)}};
    route(out);
  }

  void deliver_due() {
    Outbox due;
    while (!delayed_.empty() && delayed_.front().first <= now_ms_) {
      due.push_back(std::move(delayed_.front().second));
      delayed_.pop_front();
    }
    for (const OutMessage& message : due) pass(message);
  }

  void route(Outbox& out) {
    for (OutMessage& message : std::exchange(out, {})) {
      const bool command = message.channel == channel::kJointCommand;
      if (command && (now_ms_ < commands_held_until_ms || faults.happens(command_loss))) continue;
      const bool wire = std::ranges::find(lcm_, message.channel) != lcm_.end();
      if (wire && (faults.cut || faults.happens(faults.loss))) {
        ++faults.lost;
      } else if (wire && faults.delay_ms > 0) {
        delayed_.emplace_back(now_ms_ + faults.delay_ms, std::move(message));
      } else {
        pass(message);
      }
    }
  }

  /// As the live loop: the time that has passed, then what has waited, as much as it handles before its next tick.
  void resume_driver(Outbox& out) {
    if (driver_missed_ > 0) {
      driver_->skip_ticks(std::exchange(driver_missed_, 0));
      commands.rest();
    }
    for (size_t k = 0; k < kHandled && !waiting_.empty(); ++k) {
      driver_->receive(waiting_.front().channel, waiting_.front().bytes, out);
      waiting_.pop_front();
    }
  }

  void pass(const OutMessage& message) {
    if (message.channel == channel::kBridgeState) bridge_state = *decode<bridge_state_t>(message.bytes);
    if (message.channel == channel::kRobotState) {
      robot_states.push_back(*decode<robot_state_t>(message.bytes));
      measured_ = from_fields(robot_.chain, robot_states.back().joint_name, robot_states.back().joint_position);
      if (!keep_messages && robot_states.size() > 1000)
        robot_states.erase(robot_states.begin(), robot_states.begin() + 500);
    }
    if (keep_messages && !lcm_.empty() && message.channel == lcm_.front())
      commands_sent.emplace_back(now_ms_, message.bytes);
    for (Node* node : std::initializer_list<Node*>{&bridge_, driver_.get(), emulator_.get()}) {
      const auto inputs = node->inputs();
      if (std::ranges::find(inputs, message.channel) == inputs.end()) continue;
      if (node == driver_.get() && (driver_missed_ > 0 || now_ms_ < driver_stalled_until_ms || !waiting_.empty())) {
        waiting_.push_back(message);
        continue;
      }
      Outbox answers;
      node->receive(message.channel, message.bytes, answers);
      route(answers);
    }
  }

  RobotConfig robot_;
  BridgeNode bridge_;
  std::unique_ptr<drivers::DriverNode> driver_;
  std::unique_ptr<drivers::EmulatorNode> emulator_;
  std::vector<std::string> lcm_;
  std::deque<std::pair<int64_t, OutMessage>> delayed_;
  static constexpr size_t kHandled = 12;  // messages in a millisecond, after a stop
  std::deque<OutMessage> waiting_;        // for a driver that is stopped
  int64_t driver_missed_ = 0;
  int64_t now_ms_ = 1;
  int64_t requests_ = 0;
  int64_t setpoint_run_ = 100, setpoint_sequence_ = 0, setpoint_start_ms_ = 0;
  std::optional<JointVector> setpoint_origin_, measured_;
  JointVector previous_;
};

inline RobotConfig robot_named(const std::string& name) {
  return RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/" + name);
}

}  // namespace multireach::testing
