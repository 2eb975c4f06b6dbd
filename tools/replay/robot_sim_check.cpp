#include "tools/replay/robot_sim_check.hpp"

namespace multireach {

RobotSimCheck::RobotSimCheck(const RobotConfig& robot, FindMessage find)
    : find_(std::move(find)), arm_(simulated_arm(robot)), start_(arm_.positions()) {}

std::optional<int64_t> RobotSimCheck::apply_recorded_command(int64_t digest) {
  const auto command = decode<joint_command_t>(find_(digest));
  if (!command || !is_valid_command(*command, arm_)) return std::nullopt;
  apply_command(*command, arm_);
  return command->sequence;
}

std::optional<std::vector<uint8_t>> RobotSimCheck::compute(const sim_step_t& step, int64_t run) {
  robot_state_t state{};
  state.run = run;
  state.command_sequence = -1;
  for (size_t i = 0; i < start_.size(); ++i) arm_.command(arm_.joint_names()[i], start_[i], 0);
  if (step.previous_state_digest == 0) {
    arm_.set_state(start_, std::vector<double>(start_.size(), 0.0));
  } else {
    const auto before = decode<robot_state_t>(find_(step.previous_state_digest));
    if (!before || !plausible_utime(before->utime) || !arm_.set_state(before->joint_position, before->joint_velocity))
      return std::nullopt;
    if (step.previous_command_digest != 0 && !apply_recorded_command(step.previous_command_digest)) return std::nullopt;
    state.utime = before->utime;
    state.sequence = before->sequence + 1;
    state.run = before->run;
    state.command_sequence = before->command_sequence;
  }
  arm_.release();
  const Eigen::Vector3d force = Eigen::Map<const Eigen::Vector3d>(step.push_force_n);
  if (!step.pushed_link.empty() && !arm_.push(step.pushed_link, force)) return std::nullopt;
  for (const int64_t digest : step.step_command_digest) {
    if (digest == 0) {
      arm_.hold();
    } else if (const auto sequence = apply_recorded_command(digest)) {
      state.command_sequence = *sequence;
    } else {
      return std::nullopt;
    }
    arm_.step();
    state.utime += RobotSimNode::kStepUs;
  }
  put_joints(arm_, state);
  return encode(state);
}

}  // namespace multireach
