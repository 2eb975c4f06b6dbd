#include "tools/replay/bisect.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/channels.hpp"
#include "tools/replay/message_difference.hpp"
#include "tools/replay/recorded_log.hpp"

namespace multireach {
namespace {

struct ComparedChannel {
  std::string_view channel, node;  // node: "" for an input of the loop
};

/// Channels in the order in which their messages depend on one another.
std::vector<ComparedChannel> compared_channels() {
  std::vector<ComparedChannel> compared{{channel::kStereoImages, ""}, {channel::kObstacles, ""}};
  for (const channel::Publisher& publisher : channel::kPublishers) {
    if (publisher.node == "ideal_robot") continue;
    for (const std::string_view channel : publisher.channels) {
      if (!channel.empty()) compared.push_back({channel, publisher.node == "robot_sim" ? "robot" : publisher.node});
    }
  }
  return compared;
}

/// Identifies a message: the publisher's run, counted by restarts of its sequence numbers, and the sequence number.
using MessageId = std::pair<int64_t, int64_t>;

std::vector<std::pair<MessageId, const RecordedMessage*>> sorted_by_id(const std::vector<RecordedMessage>& messages) {
  std::vector<std::pair<MessageId, const RecordedMessage*>> names;
  int64_t run = 0, before = -1, counted = 0;
  for (const RecordedMessage& message : messages) {
    const int64_t sequence = message.sequence >= 0 ? message.sequence : counted++;
    if (sequence < before) ++run;
    before = sequence;
    names.emplace_back(MessageId{run, sequence}, &message);
  }
  std::ranges::sort(names, {}, [](const auto& entry) { return entry.first; });
  return names;
}

/// The newest run of a node that the log mentions up to this event, with its inputs.
const RecordedRun* run_at(const RecordedLog& log, std::string_view node, int64_t event) {
  const RecordedRun* found = nullptr;
  for (const RecordedRun* run : log.runs(node)) {
    if (run->first_event <= event || !found) found = run;
  }
  return found;
}

std::string described(const std::optional<ConsumedInput>& input) {
  if (!input) return "an unknown message";
  return fmt::format("{} {} after {} ticks", input->channel, input->sequence, input->ticks);
}

/// Explains why a node has sent a different message.
std::string cause_of(const RecordedLog& old_log, const RecordedLog& new_log, std::string_view node,
                     const RecordedMessage& old_message, const RecordedMessage* new_message) {
  if (node.empty()) return "the sessions differ: this is an input";
  if (node == "robot") return "its states differ for the same commands";
  const RecordedRun* a = run_at(old_log, node, old_message.event);
  const RecordedRun* b = run_at(new_log, node, new_message ? new_message->event : INT64_MAX);
  if (!a || !b) return "one of the logs lacks its NODE_INPUTS";
  for (size_t i = 0; i < std::min(a->inputs.size(), b->inputs.size()); ++i) {
    const auto &one = a->inputs[i], &other = b->inputs[i];
    // Inputs consumed after this message do not explain it.
    const bool later = one && other && std::min(one->ticks, other->ticks) > std::max<int64_t>(old_message.sequence, 0);
    if (later) break;
    if (one == other) continue;
    return fmt::format("its inputs, or their ticks, differ: input {} is {} in the old log and {} in the new", i,
                       described(one), described(other));
  }
  const auto build = [&](const RecordedLog& log) {
    const auto found = log.builds().find(std::string(node));
    return found == log.builds().end() ? std::string() : found->second;
  };
  std::string cause = "its inputs are the same";
  if (a->config_digest != b->config_digest) cause += "; its configuration differs";
  if (build(old_log) != build(new_log)) {
    cause += fmt::format("; its builds differ: {} and {}", build(old_log), build(new_log));
  }
  if (a->config_digest == b->config_digest && build(old_log) == build(new_log)) cause += ": its computation differs";
  return cause;
}

class Bisector {
 public:
  Bisector(const RecordedLog& old_log, const RecordedLog& new_log, bool common_only)
      : old_(old_log), new_(new_log), common_only_(common_only) {}

  Comparison compare() {
    for (const ComparedChannel& compared : compared_channels()) compare(compared);
    return std::move(result_);
  }

 private:
  void compare(const ComparedChannel& compared) {
    const auto ours = sorted_by_id(old_.messages(compared.channel)),
               theirs = sorted_by_id(new_.messages(compared.channel));
    if (ours.empty() && theirs.empty()) return;
    Comparison::Channel& sum = result_.channels[std::string(compared.channel)];
    size_t j = 0;
    for (const auto& [name, message] : ours) {
      while (j < theirs.size() && theirs[j].first < name) {
        ++j;
        ++sum.only_new;
      }
      if (j == theirs.size() || theirs[j].first != name) {
        ++sum.only_old;
        if (!common_only_) record_difference(compared, *message, nullptr);
        continue;
      }
      const RecordedMessage& other = *theirs[j++].second;
      if (message->digest == other.digest) {
        ++sum.equal;
      } else {
        ++sum.different;
        record_difference(compared, *message, &other);
      }
    }
    sum.only_new += static_cast<int64_t>(theirs.size() - j);
    if (sum.only_new > 0 && !common_only_ && !result_.first) {
      result_.first = {.channel = std::string(compared.channel),
                       .field = "message",
                       .old_value = "missing",
                       .new_value = fmt::format("present ({} in all)", sum.only_new),
                       .sequence = -1,
                       .node = std::string(compared.node),
                       .cause = "the new log has more messages"};
    }
  }

  void record_difference(const ComparedChannel& compared, const RecordedMessage& message,
                         const RecordedMessage* other) {
    if (result_.first && message.event >= first_event_) return;
    first_event_ = message.event;
    const MessageDifference difference =
        other ? difference_of(message.bytes, other->bytes) : MessageDifference{"message", "present", "missing"};
    result_.first = {.channel = std::string(compared.channel),
                     .field = difference.field,
                     .old_value = difference.first,
                     .new_value = difference.second,
                     .sequence = message.sequence,
                     .node = std::string(compared.node),
                     .cause = cause_of(old_, new_, compared.node, message, other)};
  }

  const RecordedLog &old_, &new_;
  bool common_only_;
  int64_t first_event_ = INT64_MAX;
  Comparison result_;
};

}  // namespace

Comparison bisect(const std::string& old_path, const std::string& new_path, bool common_only,
                  const std::function<void(double)>& progress) {
  const RecordedLog old_log(old_path, [&](double part) { progress(0.5 * part); });
  const RecordedLog new_log(new_path, [&](double part) { progress(0.5 + 0.5 * part); });
  return Bisector(old_log, new_log, common_only).compare();
}

}  // namespace multireach
