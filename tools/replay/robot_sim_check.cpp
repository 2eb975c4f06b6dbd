#include "tools/replay/robot_sim_check.hpp"

#include <algorithm>

#include "runtime/digest.hpp"

namespace multireach {

void ComputedCommands::add(int64_t first_event, int64_t sequence, int64_t digest) {
  std::vector<int64_t>& run = runs_[first_event];
  if (sequence == static_cast<int64_t>(run.size())) run.push_back(digest);
}

std::optional<int64_t> ComputedCommands::find(int64_t event, int64_t sequence) const {
  if (sequence < 0) return std::nullopt;
  // The newest run that the log told of by then and that sent so many, else an older one.
  for (auto run = runs_.upper_bound(event); run != runs_.begin();) {
    --run;
    if (sequence < static_cast<int64_t>(run->second.size())) return run->second[static_cast<size_t>(sequence)];
  }
  return std::nullopt;
}

RobotSimCheck::RobotSimCheck(const RobotConfig& robot, const ComputedCommands& commands, FindMessage find)
    : commands_(commands), find_(std::move(find)), arm_(simulated_arm(robot)), start_(arm_.positions()) {}

bool RobotSimCheck::follow_command(int64_t event, int64_t sequence) {
  const auto digest = commands_.find(event, sequence);
  const auto bytes = digest ? find_(*digest) : std::span<const uint8_t>();
  const auto command = decode<joint_command_t>(bytes);
  if (!command || !sensible(*command, arm_)) return false;
  follow(*command, arm_);
  return true;
}

std::optional<std::vector<uint8_t>> RobotSimCheck::compute(const robot_state_t& state, int64_t event) {
  robot_state_t expected = state;
  const std::vector<double> rest(start_.size(), 0.0);
  for (size_t i = 0; i < start_.size(); ++i) arm_.command(arm_.joint_names()[i], start_[i], 0);
  if (state.sequence == 0) {
    arm_.set_state(start_, rest);
    expected.utime = 0;
    expected.command_sequence = -1;
  } else {
    if (!before_ || before_->sequence + 1 != state.sequence) return std::nullopt;
    if (!arm_.set_state(before_->angle_rad, before_->velocity_rad_s)) return std::nullopt;
    expected.utime = before_->utime;
    expected.command_sequence = before_->command_sequence;
    if (before_->command_sequence >= 0 && !follow_command(event, before_->command_sequence)) return std::nullopt;
  }
  arm_.release();
  const Eigen::Vector3d force = Eigen::Map<const Eigen::Vector3d>(state.push_force_n);
  if (!state.pushed_link.empty() && !arm_.push(state.pushed_link, force)) return std::nullopt;
  for (const int64_t sequence : state.step_command_sequence) {
    if (sequence < 0) {
      arm_.hold();
    } else if (follow_command(event, sequence)) {
      expected.command_sequence = sequence;
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

RobotSimCheck::Outcome RobotSimCheck::next(const RecordedMessage& message) {
  Outcome outcome;
  auto state = decode<robot_state_t>(message.bytes);
  if (state && state->num_steps == 0) {
    before_.reset();
    return outcome;
  }
  outcome.simulated = true;
  if (state) outcome.expected = compute(*state, message.event);
  outcome.equal = outcome.expected && std::ranges::equal(*outcome.expected, message.bytes);
  outcome.broken = !sealed(message.bytes);
  // The next is computed from what this one should be.
  if (outcome.broken && outcome.expected) state = decode<robot_state_t>(*outcome.expected);
  before_ = outcome.broken && !outcome.expected ? std::nullopt : std::move(state);
  return outcome;
}

}  // namespace multireach
