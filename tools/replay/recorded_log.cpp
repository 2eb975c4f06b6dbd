#include "tools/replay/recorded_log.hpp"

#include <algorithm>
#include <multireach/node_status_t.hpp>

#include "runtime/channels.hpp"
#include "runtime/digest.hpp"
#include "runtime/message_schema.hpp"

namespace multireach {
namespace {

/// A larger gap in the listed inputs means that a number is damaged.
constexpr int64_t kLongestSilence = 1 << 22;

}  // namespace

void RecordedLog::take(const LogEvent& event) {
  const int64_t number = events_++;
  if (number == 0) first_utime_ = event.utime;
  RecordedMessage message{.event = number, .digest = 0, .sequence = -1, .utime = event.utime, .bytes = event.data};
  if (event.channel == channel::kNodeStatus) return take_status(message);
  if (event.channel == channel::kNodeInputs) return take_inputs(message);
  if (event.channel == channel::kSimStep) {
    if (!sealed(event.data)) {
      broken_.emplace_back(channel::kSimStep, message);
      return;
    }
    ++whole_[std::string(channel::kSimStep)];
  }
  message.digest = digest_of(event.data);
  if (event.channel != channel::kStereoImages) {
    const MessageSchema* schema = MessageSchemas::project().of(event.data);
    if (schema) message.sequence = sequence_of(*schema, event.data).value_or(-1);
  }
  by_digest_.emplace_back(message.digest, event.data);
  channels_[std::string(event.channel)].push_back(message);
}

void RecordedLog::take_status(const RecordedMessage& message) {
  const auto status = decode<node_status_t>(message.bytes);
  if (!status || !sealed(message.bytes)) {
    broken_.emplace_back(channel::kNodeStatus, message);
    return;
  }
  ++whole_[std::string(channel::kNodeStatus)];
  builds_[status->node] = status->build_id;
}

void RecordedLog::take_inputs(const RecordedMessage& message) {
  const auto said = decode<node_inputs_t>(message.bytes);
  const auto inputs = said && sealed(message.bytes) ? inputs_in(*said) : std::nullopt;
  if (!inputs || said->first < 0) {
    broken_.emplace_back(channel::kNodeInputs, message);
    return;
  }
  const auto [at, is_new] = runs_.try_emplace({said->node, said->run});
  RecordedRun& run = at->second;
  if (is_new) {
    run.node = said->node;
    run.run = said->run;
    run.config_digest = said->config_digest;
    run.first_event = message.event;
    run.untold = said->first;
  }
  if (said->first < run.untold && run.untold - said->first < kLongestSilence) {  // recorded out of order
    run.inputs.insert(run.inputs.begin(), static_cast<size_t>(run.untold - said->first), std::nullopt);
    run.untold = said->first;
  }
  const int64_t after = said->first - run.untold;
  if (after < 0 || after > static_cast<int64_t>(run.inputs.size()) + kLongestSilence) {
    broken_.emplace_back(channel::kNodeInputs, message);
    return;
  }
  const auto first = static_cast<size_t>(after);
  if (run.inputs.size() < first + inputs->size()) run.inputs.resize(first + inputs->size());
  bool agrees = run.config_digest == said->config_digest;
  for (size_t i = 0; i < inputs->size(); ++i) {
    auto& known = run.inputs[first + i];
    agrees = agrees && (!known || *known == (*inputs)[i]);
    known = (*inputs)[i];
  }
  if (agrees) {
    ++whole_[std::string(channel::kNodeInputs)];
  } else {
    broken_.emplace_back(channel::kNodeInputs, message);
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

int64_t RecordedLog::whole(std::string_view channel) const {
  const auto found = whole_.find(channel);
  return found == whole_.end() ? 0 : found->second;
}

}  // namespace multireach
