#pragma once

#include <functional>
#include <map>
#include <memory>
#include <multireach/bridge_request_t.hpp>
#include <multireach/joint_command_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <optional>

#include "robot_bridge/drivers/command_follower.hpp"
#include "robot_bridge/drivers/driver.hpp"
#include "robot_bridge/drivers/node/wire_port.hpp"
#include "robot_bridge/drivers/pace_check.hpp"
#include "runtime/command_filter.hpp"
#include "runtime/robot_config.hpp"

namespace multireach::drivers {

struct DriverNodeOptions {
  /// Without a command for this long, the arm decelerates to standstill before commands are followed again.
  int64_t command_timeout_us = 20000;
  double max_start_distance = 0.3;  ///< rad or m: largest distance of the first command from the measured position
  bool simulated = false;           ///< the robot is emulated
  bool accept_recorded = false;     ///< also obey commands that follow from recorded images, whose time is not now
};

/// A robot's driver with its messages: receives JOINT_COMMAND, BRIDGE_REQUEST and BRIDGE_STATE, sends ROBOT_STATE while
/// the robot obeys commands. It passes the commands of one bridge on, and adds what
/// CommandFollower does where commands are missing or begin elsewhere: extrapolation, deceleration, transition. When it
/// ends, it decelerates the arm before.
class DriverNode : public Node {
 public:
  /// `wall_clock`: microseconds since 1970.
  DriverNode(const RobotConfig& robot, std::unique_ptr<Driver> driver, Transports transports,
             const DriverNodeOptions& options, std::function<int64_t()> wall_clock);

  std::string name() const override { return "robot_driver"; }
  std::vector<std::string_view> inputs() const override;
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::optional<int64_t> next_tick() const override { return utime_; }
  int64_t tick_period_us() const override { return kTickUs; }
  void tick(Outbox& out) override;
  LateTicks late_ticks() const override { return LateTicks::kSkip; }
  void skip_ticks(int64_t ticks) override;
  bool begin_end() override;
  bool finished() const override;
  std::string state() const override;

  static constexpr int64_t kTickUs = 1000;

 private:
  /// When another process was heard last.
  struct Heard {
    int64_t us = 0;
    int64_t robot_run = 0;  ///< of the robot that a bridge commands, or would
  };

  Time now() const { return {utime_, wall_clock_()}; }
  void receive_command(std::span<const uint8_t> bytes, Outbox& out);
  void receive_request(std::span<const uint8_t> bytes, Outbox& out);
  void receive_bridge_state(std::span<const uint8_t> bytes);
  void receive_robot_state(std::span<const uint8_t> bytes);
  bool means_this_robot(const Heard& bridge) const;
  const char* refusal_of(const joint_command_t& command, JointVector& position, JointVector& velocity);
  bool is_of_now(const joint_command_t& command) const;
  bool has_waited(const joint_command_t& command) const;
  const char* refusal_of(const bridge_request_t& request) const;
  void watch_commands(Outbox& out);
  void pass_on(const robot_bridge::MotionState& state, int64_t utime, Outbox& out);
  void publish_reading(Outbox& out);
  void report_status();

  Chain chain_;
  robot_bridge::MotionLimits limits_;
  std::unique_ptr<Driver> driver_;
  WirePort port_;
  DriverNodeOptions options_;
  std::function<int64_t()> wall_clock_;
  int64_t state_period_us_;
  std::vector<std::string> joint_names_;

  int64_t utime_ = 0;
  CommandFilter commands_;
  std::string refusal_;         // of the newest refused command or request
  int64_t driver_refused_ = 0;  // messages of the robot, as counted in counters_.refused
  int64_t request_ = 0;
  std::map<int64_t, Heard> bridges_, robots_;  // by run; other robots than this one
  CommandFollower follower_;
  PaceCheck pace_;
  std::optional<int64_t> fast_run_;  // of a bridge that is faster than real time: refused until a user asks again
  int64_t waiting_until_us_ = 0;     // after this program was stopped: what comes before may have waited
  JointVector commanded_;            // last
  bool ending_ = false;
  int64_t commanded_us_ = 0, commanded_utime_ = 0;  // of the last command
  std::optional<Reading> reading_;
  int64_t sequence_ = 0, published_us_ = INT64_MIN / 2;
  std::string reported_;
};

}  // namespace multireach::drivers
