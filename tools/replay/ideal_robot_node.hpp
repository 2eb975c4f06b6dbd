#pragma once

#include "runtime/node.hpp"
#include "runtime/robot_config.hpp"

namespace multireach {

/// A robot that follows its commands exactly: JOINT_COMMAND in, ROBOT_STATE out. It has the joints of the chain and
/// starts at the start posture of section `robot_sim`. Its time starts at 0 and is independent of other clocks.
class IdealRobotNode : public Node {
 public:
  explicit IdealRobotNode(const RobotConfig& robot);

  std::string name() const override { return "ideal_robot"; }
  std::vector<std::string_view> inputs() const override;
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::optional<int64_t> next_tick() const override { return utime_; }
  int64_t tick_period_us() const override { return period_us_; }
  void tick(Outbox& out) override;
  std::optional<int64_t> config_digest() const override { return config_digest_; }
  std::string state() const override { return "running"; }

 private:
  void apply_command();

  Chain chain_;
  int64_t period_us_;
  int64_t config_digest_;
  std::vector<std::string> joint_names_;
  JointVector theta_, velocity_;
  std::vector<uint8_t> newest_command_;  // since the last tick
  int64_t utime_ = 0, sequence_ = 0, command_sequence_ = -1;
};

}  // namespace multireach
