#include "tools/replay/recorded_log.hpp"

#include <algorithm>
#include <multireach/node_status_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/digest.hpp"
#include "runtime/message_schema.hpp"

namespace multireach {
namespace {

/// A larger gap in the listed inputs means that a number is damaged.
constexpr int64_t kMaxInputGap = 1 << 22;

}  // namespace

void RecordedLog::add(const LogEvent& event) {
  const int64_t number = events_++;
  if (number == 0) first_utime_ = event.utime;
  RecordedMessage message{.event = number, .digest = 0, .sequence = -1, .utime = event.utime, .bytes = event.data};
  if (event.channel == channel::kNodeStatus) return add_status(message);
  if (event.channel == channel::kNodeInputs) return add_inputs(message);
  if (event.channel == channel::kSimStep) {
    if (!checksum_matches(event.data)) {
      invalid_messages_.emplace_back(channel::kSimStep, message);
      return;
    }
    ++valid_count_[std::string(channel::kSimStep)];
  }
  message.digest = digest_of(event.data);
  if (event.channel != channel::kStereoImages) {
    const MessageSchema* schema = MessageSchemas::project().of(event.data);
    if (schema) message.sequence = sequence_of(*schema, event.data).value_or(-1);
  }
  by_digest_.emplace_back(message.digest, event.data);
  channels_[std::string(event.channel)].push_back(message);
}

void RecordedLog::add_status(const RecordedMessage& message) {
  const auto status = decode<node_status_t>(message.bytes);
  if (!status || !checksum_matches(message.bytes)) {
    invalid_messages_.emplace_back(channel::kNodeStatus, message);
    return;
  }
  ++valid_count_[std::string(channel::kNodeStatus)];
  builds_[status->node] = status->build_id;
}

void RecordedLog::add_inputs(const RecordedMessage& message) {
  const auto inputs_message = decode<node_inputs_t>(message.bytes);
  const auto inputs = inputs_message && checksum_matches(message.bytes) ? inputs_in(*inputs_message) : std::nullopt;
  if (!inputs || inputs_message->first < 0) {
    invalid_messages_.emplace_back(channel::kNodeInputs, message);
    return;
  }
  const auto [at, is_new] = runs_.try_emplace({inputs_message->node, inputs_message->run});
  RecordedRun& run = at->second;
  if (is_new) {
    run.node = inputs_message->node;
    run.run = inputs_message->run;
    run.config_digest = inputs_message->config_digest;
    run.sender_run = inputs_message->sender_run;
    run.first_event = message.event;
    run.unlisted_inputs = inputs_message->first;
  }
  if (inputs_message->first < run.unlisted_inputs &&
      run.unlisted_inputs - inputs_message->first < kMaxInputGap) {  // recorded out of order
    run.inputs.insert(run.inputs.begin(), static_cast<size_t>(run.unlisted_inputs - inputs_message->first),
                      std::nullopt);
    run.unlisted_inputs = inputs_message->first;
  }
  const int64_t after = inputs_message->first - run.unlisted_inputs;
  if (after < 0 || after > static_cast<int64_t>(run.inputs.size()) + kMaxInputGap) {
    invalid_messages_.emplace_back(channel::kNodeInputs, message);
    return;
  }
  const auto first = static_cast<size_t>(after);
  if (run.inputs.size() < first + inputs->size()) run.inputs.resize(first + inputs->size());
  bool agrees = run.config_digest == inputs_message->config_digest;
  for (size_t i = 0; i < inputs->size(); ++i) {
    auto& known = run.inputs[first + i];
    agrees = agrees && (!known || *known == (*inputs)[i]);
    known = (*inputs)[i];
  }
  if (agrees) {
    ++valid_count_[std::string(channel::kNodeInputs)];
  } else {
    invalid_messages_.emplace_back(channel::kNodeInputs, message);
  }
}

void RecordedLog::finish() {
  std::ranges::sort(by_digest_, {}, &std::pair<int64_t, std::span<const uint8_t>>::first);
}

const std::vector<RecordedMessage>& RecordedLog::messages(std::string_view channel) const {
  static const std::vector<RecordedMessage> kNone;
  const auto found = channels_.find(channel);
  return found == channels_.end() ? kNone : found->second;
}

std::vector<const RecordedRun*> RecordedLog::runs(std::string_view node) const {
  std::vector<const RecordedRun*> found;
  for (const auto& [key, run] : runs_) {
    if (run.node == node) found.push_back(&run);
  }
  std::ranges::sort(found, {}, &RecordedRun::first_event);
  return found;
}

std::span<const uint8_t> RecordedLog::bytes_of(int64_t digest) const {
  const auto found =
      std::ranges::lower_bound(by_digest_, digest, {}, &std::pair<int64_t, std::span<const uint8_t>>::first);
  if (found == by_digest_.end() || found->first != digest) return {};
  return found->second;
}

int64_t RecordedLog::valid_count(std::string_view channel) const {
  const auto found = valid_count_.find(channel);
  return found == valid_count_.end() ? 0 : found->second;
}

}  // namespace multireach
