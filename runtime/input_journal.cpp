#include "runtime/input_journal.hpp"

#include <algorithm>
#include <array>

#include "runtime/channels.hpp"
#include "runtime/digest.hpp"

namespace multireach {
namespace {

/// By the constants of node_inputs_t.
constexpr std::array kChannels{channel::kStereoImages,  channel::kTarget,       channel::kObstacles,
                               channel::kJointSetpoint, channel::kJointCommand, channel::kRobotState,
                               channel::kPerturbation};
static_assert(kChannels[node_inputs_t::PERTURBATION] == channel::kPerturbation);

}  // namespace

InputJournal::InputJournal(std::string node, int64_t run, int64_t config_digest, size_t repeated)
    : node_(std::move(node)), run_(run), config_digest_(config_digest), repeated_(repeated) {}

std::optional<ConsumedInput> InputJournal::took(const Receipt& receipt, std::string_view channel,
                                                std::span<const uint8_t> bytes) {
  const auto known = std::ranges::find(kChannels, channel);
  if (receipt.effect == Receipt::Effect::kNone || known == kChannels.end()) return std::nullopt;
  if (receipt.effect == Receipt::Effect::kReplaces) {
    const auto unsaid = newest_.rbegin() + static_cast<std::ptrdiff_t>(taken_ - said_);
    const auto replaced =
        std::find_if(newest_.rbegin(), unsaid, [&](const ConsumedInput& input) { return input.channel == channel; });
    if (replaced != unsaid && replaced->ticks == ticks_) {
      newest_.erase(std::next(replaced).base());
      --taken_;
    }
  }
  newest_.push_back({ticks_, *known, receipt.sequence, digest_of(bytes)});
  ++taken_;
  while (newest_.size() > repeated_ + static_cast<size_t>(taken_ - said_)) newest_.pop_front();
  return newest_.back();
}

std::optional<std::vector<uint8_t>> InputJournal::news() {
  if (said_ == taken_) return std::nullopt;
  node_inputs_t message{};
  message.node = node_;
  message.run = run_;
  message.config_digest = config_digest_;
  message.first = taken_ - static_cast<int64_t>(newest_.size());
  message.num_inputs = static_cast<int32_t>(newest_.size());
  for (const ConsumedInput& input : newest_) {
    message.ticks.push_back(input.ticks);
    message.channel.push_back(number_of(input));
    message.sequence.push_back(input.sequence);
    message.digest.push_back(input.digest);
  }
  said_ = taken_;
  while (newest_.size() > repeated_) newest_.pop_front();
  auto bytes = encode(message);
  if (bytes) seal(*bytes);
  return bytes;
}

int8_t number_of(const ConsumedInput& input) {
  return static_cast<int8_t>(std::ranges::find(kChannels, input.channel) - kChannels.begin());
}

std::optional<std::vector<ConsumedInput>> inputs_in(const node_inputs_t& message) {
  std::vector<ConsumedInput> inputs;
  for (size_t i = 0; i < message.ticks.size(); ++i) {
    const auto channel = static_cast<size_t>(message.channel[i]);
    if (message.channel[i] < 0 || channel >= kChannels.size()) return std::nullopt;
    inputs.push_back({message.ticks[i], kChannels[channel], message.sequence[i], message.digest[i]});
  }
  return inputs;
}

}  // namespace multireach
