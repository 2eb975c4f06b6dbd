#include "runtime/input_journal.hpp"

#include <algorithm>

#include "runtime/digest.hpp"

namespace multireach {
InputJournal::InputJournal(std::string node, int64_t run, int64_t sender_run, int64_t config_digest, size_t repeated)
    : node_(std::move(node)), run_(run), sender_run_(sender_run), config_digest_(config_digest), repeated_(repeated) {}

std::optional<ConsumedInput> InputJournal::record(const Receipt& receipt, std::string_view channel,
                                                  std::span<const uint8_t> bytes) {
  if (receipt.effect == Receipt::Effect::kNone) return std::nullopt;
  if (receipt.effect == Receipt::Effect::kReplaces) {
    const auto unpublished_end = newest_.rbegin() + static_cast<std::ptrdiff_t>(recorded_ - published_);
    // Ticks that were skipped may have depended on what came before them.
    const auto replaced = std::find_if(newest_.rbegin(), unpublished_end, [&](const ConsumedInput& input) {
      return input.channel == channel || input.channel == kClockInput;
    });
    if (replaced != unpublished_end && replaced->ticks == ticks_ && replaced->channel == channel) {
      newest_.erase(std::next(replaced).base());
      --recorded_;
    }
  }
  newest_.push_back({ticks_, std::string(channel), receipt.sequence, digest_of(bytes)});
  ++recorded_;
  while (newest_.size() > repeated_ + static_cast<size_t>(recorded_ - published_)) newest_.pop_front();
  return newest_.back();
}

void InputJournal::record_skip(int64_t ticks) {
  newest_.push_back({ticks_, std::string(kClockInput), ticks, 0});
  ++recorded_;
}

bool InputJournal::next_message(std::vector<uint8_t>& bytes) {
  if (published_ == recorded_) return false;
  message_.node = node_;
  message_.run = run_;
  message_.sender_run = sender_run_;
  message_.config_digest = config_digest_;
  message_.first = recorded_ - static_cast<int64_t>(newest_.size());
  message_.num_inputs = static_cast<int32_t>(newest_.size());
  message_.ticks.clear();
  message_.channel_name.clear();
  message_.channel.clear();
  message_.sequence.clear();
  message_.digest.clear();
  for (const ConsumedInput& input : newest_) {
    message_.ticks.push_back(input.ticks);
    append_channel(input.channel, message_.channel_name, message_.channel);
    message_.sequence.push_back(input.sequence);
    message_.digest.push_back(input.digest);
  }
  message_.num_channels = static_cast<int32_t>(message_.channel_name.size());
  published_ = recorded_;
  while (newest_.size() > repeated_) newest_.pop_front();
  if (!encode_into(message_, bytes)) return false;
  set_checksum(bytes);
  return true;
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
