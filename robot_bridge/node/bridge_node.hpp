#pragma once

#include <array>
#include <multireach/joint_command_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/robot_state_t.hpp>

#include "robot_bridge/bridge.hpp"
#include "runtime/node.hpp"
#include "runtime/robot_config.hpp"

namespace multireach {

/// Reads the section `bridge`; all keys have defaults. Throws InputError.
robot_bridge::BridgeOptions bridge_options_from(const RobotConfig& robot);
/// The section `bridge` of the reference page.
std::string bridge_config_reference();

/// Receives JOINT_SETPOINT, ROBOT_STATE and BRIDGE_REQUEST; sends JOINT_COMMAND at 1 kHz while it commands the robot,
/// and BRIDGE_STATE.
class BridgeNode : public Node {
 public:
  explicit BridgeNode(const RobotConfig& robot);

  std::string name() const override { return "bridge"; }
  std::vector<std::string_view> inputs() const override;
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::optional<int64_t> next_tick() const override { return bridge_.next_tick(); }
  int64_t tick_period_us() const override { return options_.period_us; }
  void tick(Outbox& out) override;
  LateTicks late_ticks() const override { return LateTicks::kSkip; }
  void skip_ticks(int64_t ticks) override { bridge_.skip(ticks); }
  std::optional<OutMessage> shutdown_request() const override;
  void skip_inputs(int64_t inputs, std::string_view channel) override;
  std::optional<int64_t> config_digest() const override { return config_digest_; }
  std::string state() const override;

 private:
  Receipt receive_robot_state(std::span<const uint8_t> bytes, Outbox& out);
  Receipt receive_setpoint(std::span<const uint8_t> bytes, Outbox& out);
  Receipt receive_request(std::span<const uint8_t> bytes, Outbox& out);
  void send_state(Outbox& out);
  std::string cause() const;

  robot_bridge::BridgeOptions options_;
  Chain chain_;
  robot_bridge::Bridge bridge_;
  joint_command_t command_;
  robot_state_t robot_state_;  // received last, as is
  joint_setpoint_t setpoint_;
  int64_t config_digest_;
  SequenceGapCounter setpoints_, robot_states_;
  int64_t robot_state_sequence_ = -1;
  int64_t sequence_ = 0;
  int64_t far_run_ = 0;      // see bridge_state_t
  std::string robot_fault_;  // the newest one that the robot reported
  int64_t request_ = 0;
  bool request_accepted_ = false;
  std::array<int64_t, robot_bridge::kNumVerdicts> verdicts_{};  // number of set-points by verdict
  std::array<int64_t, 4> refused_states_{};                     // number of ROBOT_STATEs by MeasurementVerdict
  robot_bridge::Command last_;
};

}  // namespace multireach
