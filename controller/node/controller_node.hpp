#pragma once

#include <multireach/target_choice_t.hpp>

#include "controller/reach_controller.hpp"
#include "runtime/followed_run.hpp"
#include "runtime/node.hpp"
#include "runtime/robot_config.hpp"

namespace multireach {

/// Receives TARGET, TARGET_CHOICE, OBSTACLES, ROBOT_STATE and BRIDGE_STATE; sends JOINT_SETPOINT and CONTROLLER_STATE
/// once a tick. When the first target arrives, or when the bridge says that the robot is elsewhere, the controller
/// starts from the joint positions of the newest ROBOT_STATE. From then on it integrates its own joint positions; with
/// `feedback: measured` these follow the measured ones when the arm is pushed.
class ControllerNode : public Node {
 public:
  explicit ControllerNode(const RobotConfig& robot);

  std::string name() const override { return "controller"; }
  std::vector<std::string_view> inputs() const override;
  Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) override;
  std::optional<int64_t> next_tick() const override { return controller_.next_tick(); }
  int64_t tick_period_us() const override { return controller_.options().tick_us; }
  /// Most targets arrive within this time of the earliest; without it, about half of those of a tick's own time would
  /// wait for the next tick.
  int64_t tick_delay_us() const override { return controller_.target_waits() ? 0 : 4000; }
  void tick(Outbox& out) override;
  std::optional<int64_t> config_digest() const override { return config_digest_; }
  std::string state() const override;

 private:
  Receipt receive_target(std::span<const uint8_t> bytes);
  Receipt receive_obstacles(std::span<const uint8_t> bytes);
  Receipt receive_choice(std::span<const uint8_t> bytes);
  Receipt receive_robot_state(std::span<const uint8_t> bytes);
  Receipt receive_bridge_state(std::span<const uint8_t> bytes);
  std::string choice_text() const;
  std::string reach_text() const;
  std::string joint_at_target() const;

  static constexpr int64_t kChoiceSilence = 3000000;  // us: who has chosen and was not heard for this long is gone

  controller::ReachController controller_;
  std::vector<std::string> joint_names_;
  std::optional<std::string> target_name_;  // target to reach for; if none is configured, the first that is seen
  int64_t config_digest_;
  bool uncalibrated_ = false;  // whether the newest target of that name was refused because the camera pose is unknown
  target_choice_t choice_{};
  FollowedRun target_run_, robot_run_, bridge_run_, choice_run_{kChoiceSilence};
  std::optional<std::vector<controller::Obstacle>> new_obstacles_;  // received since the last tick
  bool start_again_ = false;    // from the next robot state, since the bridge refuses the set-points as too far from it
  bool started_again_ = false;  // since the last tick
  bool measured_ = false;       // whether a robot state was taken since the first tick
  SequenceGapCounter targets_, obstacles_, robot_states_;
  int64_t target_sequence_ = -1, robot_state_sequence_ = -1, obstacles_sequence_ = -1;
  int64_t sequence_ = 0;
  controller::ReachOutput last_;
};

}  // namespace multireach
