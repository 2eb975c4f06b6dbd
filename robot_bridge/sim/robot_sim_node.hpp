#pragma once

#include <multireach/joint_command_t.hpp>
#include <multireach/robot_state_t.hpp>

#include "robot_bridge/sim/mujoco_arm.hpp"
#include "runtime/command_filter.hpp"
#include "runtime/node.hpp"
#include "runtime/robot_config.hpp"

namespace multireach {

/// The simulated robot: receives JOINT_COMMAND and PERTURBATION, sends ROBOT_STATE. Its clock starts at 0 and is
/// independent of others. Each state message records the commands and the push since the previous state, so that it can
/// be recomputed from that state alone. For this, pushes begin and end only when a state is sent.
class RobotSimNode : public Node {
 public:
  explicit RobotSimNode(const RobotConfig& robot);

  std::string name() const override { return "robot_sim"; }
  std::vector<std::string_view> inputs() const override;
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::optional<int64_t> next_tick() const override { return utime_; }
  int64_t tick_period_us() const override { return kStepUs; }
  void tick(Outbox& out) override;
  LateTicks late_ticks() const override { return LateTicks::kPause; }
  std::string state() const override;

  static constexpr int64_t kStepUs = 1000;

 private:
  struct Push {
    std::string link;
    Eigen::Vector3d force_n{0, 0, 0};
    int64_t duration_us = 0;
  };

  void receive_command(std::span<const uint8_t> bytes);
  void receive_push(std::span<const uint8_t> bytes);
  void update_push();

  MujocoArm arm_;
  int64_t state_period_us_;
  int64_t utime_ = 0;
  int64_t commanded_utime_ = 0;
  int64_t sequence_ = 0;
  int64_t command_digest_ = 0;
  int64_t state_digest_ = 0, state_command_digest_ = 0;  // of the last ROBOT_STATE, and of the command consumed by then
  std::vector<int64_t> steps_;  // digests of the commands followed in each step since the last state
  std::optional<Push> next_push_, push_;
  int64_t push_until_ = 0;
  CommandFilter commands_;
  std::string refusal_;  // why the newest refused message was refused
};

/// Whether the arm has every joint of the command and all numbers are plausible. Other commands are refused.
[[nodiscard]] bool is_valid_command(const joint_command_t& command, const MujocoArm& arm);
/// Passes a command for which is_valid_command() is true to the arm.
void apply_command(const joint_command_t& command, MujocoArm& arm);
/// The arm of a robot.yaml, at the start configuration of its section `robot_sim`. Throws InputError.
MujocoArm simulated_arm(const RobotConfig& robot);
/// The section `robot_sim` of the reference page.
std::string robot_sim_config_reference();
/// Writes joint names, positions, velocities and torques to `state`.
void put_joints(const MujocoArm& arm, robot_state_t& state);

}  // namespace multireach
