#pragma once

#include "runtime/node.hpp"
#include "runtime/nodes/robot_config.hpp"
#include "tools/robot_sim/mujoco_arm.hpp"

namespace multireach {

/// The simulated robot: JOINT_COMMAND and PERTURBATION in, ROBOT_STATE out. Its time begins at 0 and is its own.
class RobotSimNode : public Node {
 public:
  explicit RobotSimNode(const RobotConfig& robot);

  std::string name() const override { return "robot_sim"; }
  std::vector<std::string_view> inputs() const override;
  std::optional<int64_t> receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::optional<int64_t> next_tick() const override { return utime_; }
  int64_t tick_period_us() const override { return kStepUs; }
  void tick(Outbox& out) override;
  std::string state() const override { return command_sequence_ < 0 ? "waiting for a command" : "running"; }

 private:
  static constexpr int64_t kStepUs = 1000;

  void receive_command(std::span<const uint8_t> bytes);

  MujocoArm arm_;
  int64_t state_period_us_ = 5000;
  int64_t utime_ = 0;
  int64_t commanded_utime_ = 0;
  int64_t sequence_ = 0, command_sequence_ = -1;
  SequenceWatch commands_;
};

}  // namespace multireach
