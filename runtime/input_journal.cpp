#include "runtime/input_journal.hpp"

#include <algorithm>

#include "runtime/digest.hpp"

namespace multireach {
InputJournal::InputJournal(std::string node, int64_t run, int64_t config_digest, size_t repeated)
    : node_(std::move(node)), run_(run), config_digest_(config_digest), repeated_(repeated) {}

std::optional<ConsumedInput> InputJournal::took(const Receipt& receipt, std::string_view channel,
                                                std::span<const uint8_t> bytes) {
  if (receipt.effect == Receipt::Effect::kNone) return std::nullopt;
  if (receipt.effect == Receipt::Effect::kReplaces) {
    const auto unsaid = newest_.rbegin() + static_cast<std::ptrdiff_t>(taken_ - said_);
    const auto replaced =
        std::find_if(newest_.rbegin(), unsaid, [&](const ConsumedInput& input) { return input.channel == channel; });
    if (replaced != unsaid && replaced->ticks == ticks_) {
      newest_.erase(std::next(replaced).base());
      --taken_;
    }
  }
  newest_.push_back({ticks_, std::string(channel), receipt.sequence, digest_of(bytes)});
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
    append_channel(input.channel, message.channel_name, message.channel);
    message.sequence.push_back(input.sequence);
    message.digest.push_back(input.digest);
  }
  message.num_channels = static_cast<int32_t>(message.channel_name.size());
  said_ = taken_;
  while (newest_.size() > repeated_) newest_.pop_front();
  auto bytes = encode(message);
  if (bytes) seal(*bytes);
  return bytes;
}

void append_channel(const std::string& channel, std::vector<std::string>& names, std::vector<int8_t>& indices) {
  const auto found = std::ranges::find(names, channel);
  indices.push_back(static_cast<int8_t>(found - names.begin()));
  if (found == names.end()) names.push_back(channel);
}

std::optional<std::vector<ConsumedInput>> inputs_in(const node_inputs_t& message) {
  std::vector<ConsumedInput> inputs;
  for (size_t i = 0; i < message.ticks.size(); ++i) {
    const auto channel = static_cast<size_t>(message.channel[i]);
    if (message.channel[i] < 0 || channel >= message.channel_name.size()) return std::nullopt;
    inputs.push_back({message.ticks[i], message.channel_name[channel], message.sequence[i], message.digest[i]});
  }
  return inputs;
}

}  // namespace multireach
