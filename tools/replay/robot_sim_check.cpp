#include "tools/replay/robot_sim_check.hpp"

#include <algorithm>

#include "runtime/digest.hpp"

namespace multireach {

RobotSimCheck::RobotSimCheck(const RobotConfig& robot, FindMessage find)
    : find_(std::move(find)), arm_(simulated_arm(robot)), start_(arm_.positions()) {}

std::optional<int64_t> RobotSimCheck::follow_command(int64_t digest) {
  const auto command = decode<joint_command_t>(find_(digest));
  if (!command || !sensible(*command, arm_)) return std::nullopt;
  follow(*command, arm_);
  return command->sequence;
}

std::optional<std::vector<uint8_t>> RobotSimCheck::compute(const robot_state_t& state) {
  robot_state_t expected = state;
  for (size_t i = 0; i < start_.size(); ++i) arm_.command(arm_.joint_names()[i], start_[i], 0);
  if (state.before_digest == 0) {
    arm_.set_state(start_, std::vector<double>(start_.size(), 0.0));
    expected.utime = expected.sequence = expected.command_digest = 0;
    expected.command_sequence = -1;
  } else {
    const auto before = decode<robot_state_t>(find_(state.before_digest));
    if (!before || !arm_.set_state(before->angle_rad, before->velocity_rad_s)) return std::nullopt;
    if (before->command_digest != 0 && !follow_command(before->command_digest)) return std::nullopt;
    expected.utime = before->utime;
    expected.sequence = before->sequence + 1;
    expected.command_sequence = before->command_sequence;
    expected.command_digest = before->command_digest;
  }
  arm_.release();
  const Eigen::Vector3d force = Eigen::Map<const Eigen::Vector3d>(state.push_force_n);
  if (!state.pushed_link.empty() && !arm_.push(state.pushed_link, force)) return std::nullopt;
  for (const int64_t digest : state.step_command_digest) {
    if (digest == 0) {
      arm_.hold();
    } else if (const auto sequence = follow_command(digest)) {
      expected.command_sequence = *sequence;
      expected.command_digest = digest;
    } else {
      return std::nullopt;
    }
    arm_.step();
    expected.utime += RobotSimNode::kStepUs;
  }
  put_joints(arm_, expected);
  auto bytes = encode(expected);
  if (bytes) seal(*bytes);
  return bytes;
}

RobotSimCheck::Outcome RobotSimCheck::check(const RecordedMessage& message) {
  Outcome outcome;
  const auto state = decode<robot_state_t>(message.bytes);
  if (state && state->num_steps == 0) return outcome;
  outcome.simulated = true;
  if (state) outcome.expected = compute(*state);
  outcome.equal = outcome.expected && std::ranges::equal(*outcome.expected, message.bytes);
  outcome.broken = !sealed(message.bytes);
  return outcome;
}

}  // namespace multireach
