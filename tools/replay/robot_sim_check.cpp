#include "tools/replay/robot_sim_check.hpp"

#include <algorithm>

#include "runtime/digest.hpp"

namespace multireach {

void ComputedCommands::add(int64_t first_event, int64_t sequence, int64_t digest) {
  if (runs_.empty() || runs_.back().first_event != first_event) runs_.push_back({first_event, {}});
  std::vector<int64_t>& digests = runs_.back().digests;
  if (sequence == static_cast<int64_t>(digests.size())) digests.push_back(digest);
}

size_t ComputedCommands::run_at(int64_t event) const {
  size_t run = 0;
  while (run + 1 < runs_.size() && runs_[run + 1].first_event <= event) ++run;
  return run;
}

std::optional<int64_t> ComputedCommands::find(size_t run, int64_t sequence) const {
  if (run >= runs_.size() || sequence < 0) return std::nullopt;
  const std::vector<int64_t>& digests = runs_[run].digests;
  if (sequence >= static_cast<int64_t>(digests.size())) return std::nullopt;
  return digests[static_cast<size_t>(sequence)];
}

RobotSimCheck::RobotSimCheck(const RobotConfig& robot, const ComputedCommands& commands, FindMessage find)
    : commands_(commands), find_(std::move(find)), arm_(simulated_arm(robot)), start_(arm_.positions()) {}

bool RobotSimCheck::follow_command(size_t run, int64_t sequence) {
  const auto digest = commands_.find(run, sequence);
  const auto bytes = digest ? find_(*digest) : std::span<const uint8_t>();
  const auto command = decode<joint_command_t>(bytes);
  if (!command || !sensible(*command, arm_)) return false;
  follow(*command, arm_);
  return true;
}

std::optional<std::vector<uint8_t>> RobotSimCheck::compute(const robot_state_t& state, size_t run) {
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
    if (before_->command_sequence >= 0 && !follow_command(run, before_->command_sequence)) return std::nullopt;
  }
  arm_.release();
  const Eigen::Vector3d force = Eigen::Map<const Eigen::Vector3d>(state.push_force_n);
  if (!state.pushed_link.empty() && !arm_.push(state.pushed_link, force)) return std::nullopt;
  for (const int64_t sequence : state.step_command_sequence) {
    // A bridge that was started again counts from 0.
    if (sequence >= 0 && sequence < expected.command_sequence) ++run;
    if (sequence < 0) {
      arm_.hold();
    } else if (follow_command(run, sequence)) {
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
  // Which run of the bridge it was is told by the log's order, but for what the recorder lost: then one that fits.
  const auto equals = [&] { return outcome.expected && std::ranges::equal(*outcome.expected, message.bytes); };
  if (state) outcome.expected = compute(*state, commands_.run_at(message.event));
  for (size_t run = 0; state && run < commands_.runs() && !equals(); ++run) {
    if (auto other = compute(*state, run)) {
      const bool fits = std::ranges::equal(*other, message.bytes);
      if (fits || !outcome.expected) outcome.expected = std::move(other);
    }
  }
  outcome.equal = equals();
  outcome.broken = !sealed(message.bytes);
  // The next is computed from what this one should be.
  if (outcome.broken && outcome.expected) state = decode<robot_state_t>(*outcome.expected);
  before_ = outcome.broken && !outcome.expected ? std::nullopt : std::move(state);
  return outcome;
}

}  // namespace multireach
