#pragma once

#include <multireach/joint_command_t.hpp>
#include <multireach/robot_state_t.hpp>

#include "robot_bridge/sim/mujoco_arm.hpp"
#include "runtime/node.hpp"
#include "runtime/robot_config.hpp"

namespace multireach {

/// The simulated robot: JOINT_COMMAND and PERTURBATION in, ROBOT_STATE out. Its time begins at 0 and is its own.
/// Each state says which commands and which push led to it from the state before, so that it can be computed again
/// from that one alone. A push begins and ends with a state.
class RobotSimNode : public Node {
 public:
  explicit RobotSimNode(const RobotConfig& robot);

  std::string name() const override { return "robot_sim"; }
  std::vector<std::string_view> inputs() const override;
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::optional<int64_t> next_tick() const override { return utime_; }
  int64_t tick_period_us() const override { return kStepUs; }
  void tick(Outbox& out) override;
  std::string state() const override { return command_sequence_ < 0 ? "waiting for a command" : "running"; }

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
  int64_t sequence_ = 0, command_sequence_ = -1;
  int64_t command_digest_ = 0, before_digest_ = 0;
  std::vector<int64_t> steps_;  // the commands followed since the last state
  std::optional<Push> next_push_, push_;
  int64_t push_until_ = 0;
  SequenceWatch commands_;
};

/// Whether every joint of a command is one of the arm's and every number can be one; only then it is obeyed.
bool sensible(const joint_command_t& command, const MujocoArm& arm);
/// Lets the arm follow a sensible command.
void follow(const joint_command_t& command, MujocoArm& arm);
/// The arm of a robot's file, at the start posture of section `robot_sim`. Throws InputError.
MujocoArm simulated_arm(const RobotConfig& robot);
/// Fills in joints, positions, velocities and torques.
void put_joints(const MujocoArm& arm, robot_state_t& state);

}  // namespace multireach
