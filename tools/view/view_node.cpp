#include "tools/view/view_node.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <multireach/node_status_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/joint_fields.hpp"

namespace multireach {

std::vector<std::string_view> ViewNode::inputs() const {
  return {channel::kTarget, channel::kJointSetpoint, channel::kJointCommand, channel::kRobotState,
          channel::kNodeStatus};
}

Receipt ViewNode::receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox&) {
  ++received_[std::string(channel)];
  if (channel == channel::kTarget) {
    if (const auto target = decode_and_count<target_t>(bytes)) {
      target_ = Eigen::Map<const Eigen::Vector3d>(target->position_m);
      target_seen_ = target->status == target_t::STATUS_TRACKED;
    }
  } else if (channel == channel::kRobotState) {
    const auto state = decode_and_count<robot_state_t>(bytes);
    const auto theta = state ? from_fields(chain_, state->joint_name, state->joint_position) : std::nullopt;
    if (theta) hand_ = chain_.position(*theta);
  } else if (channel == channel::kNodeStatus) {
    if (const auto status = decode_and_count<node_status_t>(bytes)) {
      // Of the bridge, counts of refused messages follow.
      const size_t end = status->node == "bridge" ? status->state.find(';') : std::string::npos;
      nodes_[status->node] = {status->state.substr(0, end), next_tick_us_};
    }
  }
  return {};
}

std::set<std::string> ViewNode::missing() const {
  std::set<std::string> missing;
  for (const std::string& node : options_.wait_for) {
    if (!nodes_.contains(node)) missing.insert(node);
  }
  return missing;
}

std::string ViewNode::state_of(const std::string& node) const {
  const auto found = nodes_.find(node);
  const int64_t since_us = found == nodes_.end() ? 0 : found->second.at_us;
  const double age_s = static_cast<double>(next_tick_us_ - since_us) * 1e-6 / options_.speed;
  if (found != nodes_.end() && age_s < kOldS) return found->second.state;
  return fmt::format("not heard in {:.0f} s", age_s);
}

std::string ViewNode::line() const {
  const auto place = [](const std::optional<Eigen::Vector3d>& p) {
    return p ? fmt::format("{:6.3f} {:6.3f} {:6.3f}", p->x(), p->y(), p->z()) : std::string("        -           ");
  };
  const auto rate = [this](std::string_view channel) {
    const auto found = rate_hz_.find(channel);
    return found == rate_hz_.end() ? 0.0 : found->second;
  };
  const std::string distance =
      target_ && hand_ ? fmt::format("{:6.1f} mm", 1e3 * (*target_ - *hand_).norm()) : std::string("    -    ");
  return fmt::format(
      "target {}{} | hand {} | {} | Hz: target {:4.0f} set-point {:3.0f} command {:5.0f} state {:4.0f} | "
      "controller {} | bridge {}",
      place(target_), target_seen_ ? " " : "?", place(hand_), distance, rate(channel::kTarget),
      rate(channel::kJointSetpoint), rate(channel::kJointCommand), rate(channel::kRobotState), state_of("controller"),
      state_of("bridge"));
}

void ViewNode::tick(Outbox&) {
  next_tick_us_ += kPeriodUs;
  for (auto& [channel, count] : received_) {
    double& rate = rate_hz_[channel];
    rate += 0.5 * (count * 1e6 / kPeriodUs - rate);
    count = 0;
  }
  if (!options_.wait_for.empty()) return;
  if (options_.terminal) {
    std::fprintf(stderr, "\r%s\033[K", line().c_str());
  } else if (next_tick_us_ % (20 * kPeriodUs) == 0) {
    std::fprintf(stderr, "%s\n", line().c_str());
  }
}

}  // namespace multireach
