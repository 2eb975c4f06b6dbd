#include "tools/replay/verify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <multireach/node_inputs_t.hpp>
#include <multireach/target_t.hpp>
#include <set>
#include <unordered_map>

#include "runtime/channels.hpp"
#include "runtime/digest.hpp"
#include "runtime/message.hpp"
#include "runtime/message_schema.hpp"
#include "runtime/program.hpp"
#include "tools/replay/message_difference.hpp"
#include "tools/replay/robot_sim_check.hpp"

namespace multireach {
namespace {

/// Channels whose messages hold a digest of themselves.
constexpr std::array kWithChecksum{channel::kNodeInputs, channel::kNodeStatus, channel::kSimStep};

class Verifier {
 public:
  Verifier(const RecordedLog& log, const NodeConfigs& configs) : log_(log), configs_(configs) {}

  Verification verify(const std::function<void(double)>& progress) {
    for (size_t i = 0; i < channel::kPublishers.size(); ++i) {
      verify_node(channel::kPublishers[i]);
      progress(0.5 + 0.5 * static_cast<double>(i + 1) / static_cast<double>(channel::kPublishers.size()));
    }
    for (const std::string_view channel : kWithChecksum) {
      if (log_.valid_count(channel) == 0) continue;
      Verification::Channel& sum = sum_of(channel);
      sum.equal = sum.messages = log_.valid_count(channel);
      sum.computed = true;
    }
    for (const auto& [channel, message] : log_.invalid_messages()) {
      Verification::Channel& sum = sum_of(channel);
      ++sum.messages;
      ++sum.different;
      record_difference(channel, "", message, {"message", "fails its own digest, or contradicts other messages", ""});
    }
    for (const auto& [node, build] : log_.builds()) {
      if (build != this_build()) note(fmt::format("recorded by build {}; this is build {}", build, this_build()));
    }
    return std::move(result_);
  }

 private:
  using Digests = std::unordered_map<int64_t, size_t>;  // digest of a computed message -> index of its run

  Verification::Channel& sum_of(std::string_view channel) { return result_.channels[std::string(channel)]; }

  void note(const std::string& sentence) {
    if (std::ranges::find(result_.notes, sentence) == result_.notes.end()) result_.notes.push_back(sentence);
  }

  void record_difference(std::string_view channel, std::string_view node, const RecordedMessage& message,
                         const MessageDifference& difference) {
    if (result_.first && result_.first->event <= message.event) return;
    result_.first = {.channel = std::string(channel),
                     .node = std::string(node),
                     .field = difference.field,
                     .recorded = difference.first,
                     .computed = difference.second,
                     .event = message.event,
                     .sequence = message.sequence,
                     .utime = message.utime};
  }

  std::span<const uint8_t> find(int64_t digest) const {
    const auto bytes = log_.bytes_of(digest);
    if (!bytes.empty()) return bytes;
    const auto again = recomputed_.find(digest);
    return again == recomputed_.end() ? std::span<const uint8_t>() : std::span<const uint8_t>(again->second);
  }

  struct RecomputedRun {
    const RecordedRun* run;
    std::map<std::string_view, int64_t> uncertain_from;  // by channel: first sequence number that lacks an input
    std::set<int64_t> uncomputable{};                    // sequence numbers of vision that cannot be computed
    std::set<int64_t> restored{};                        // sequences of what was taken as it is recorded
    int64_t end = INT64_MAX;                             // first event of the next run
  };

  static int64_t sequence_in(std::span<const uint8_t> bytes) {
    const MessageSchema* schema = MessageSchemas::project().of(bytes);
    return schema ? sequence_of(*schema, bytes).value_or(-1) : -1;
  }

  void verify_node(const channel::Publisher& publisher) {
    if (publisher.node == "robot_sim") return verify_simulated_robot();
    const auto runs = log_.runs(publisher.node);
    std::map<std::string_view, Digests> computed;
    std::vector<RecomputedRun> recomputed;
    for (const RecordedRun* run : runs) {
      recomputed.push_back({run, {}});
      if (recomputed.size() < runs.size()) recomputed.back().end = runs[recomputed.size()]->first_event;
      recompute_run(publisher, recomputed.back(), recomputed.size() - 1, computed);
    }
    for (const std::string_view channel : publisher.channels) {
      if (!channel.empty()) compare(publisher, channel, recomputed, computed[channel]);
    }
  }

  /// What vision's run is recorded to have remembered after each TARGET, by sequence number.
  std::map<int64_t, const RecordedMessage*> recorded_states(const RecomputedRun& recomputed) const {
    std::map<int64_t, const RecordedMessage*> found;
    for (const RecordedMessage& message : log_.messages(channel::kTrackerState)) {
      if (message.event > recomputed.run->first_event && message.event < recomputed.end)
        found.emplace(message.sequence, &message);
    }
    return found;
  }

  void recompute_run(const channel::Publisher& publisher, RecomputedRun& recomputed, size_t number,
                     std::map<std::string_view, Digests>& computed) {
    const RecordedRun& run = *recomputed.run;
    std::map<std::string_view, int64_t> next;  // sequence number, by channel
    std::optional<std::map<int64_t, const RecordedMessage*>> recorded;
    const Recomputation io{.find = [this](int64_t digest) { return find(digest); },
                           .recorded = [&](int64_t sequence) -> std::span<const uint8_t> {
                             if (publisher.node != "vision") return {};
                             if (!recorded) recorded = recorded_states(recomputed);
                             const auto found = recorded->find(sequence);
                             if (found == recorded->end()) return {};
                             return found->second->bytes;
                           },
                           .restored = [&](int64_t sequence) { recomputed.restored.insert(sequence); },
                           .uncomputable = [&](int64_t sequence) { recomputed.uncomputable.insert(sequence); },
                           .sent =
                               [&](const OutMessage& message, bool certain) {
                                 const int64_t digest = digest_of(message.bytes);
                                 computed[message.channel].emplace(digest, number);
                                 const int64_t sequence = sequence_in(message.bytes);
                                 if (certain) {
                                   recomputed.uncertain_from.erase(message.channel);
                                 } else {
                                   recomputed.uncertain_from.try_emplace(message.channel, sequence);
                                 }
                                 next[message.channel] = sequence + 1;
                                 const bool known = !log_.bytes_of(digest).empty();
                                 // Other nodes may have consumed this message although the recorder lost it.
                                 // A digest tells whether it is the message that was sent, certain or not.
                                 const bool lost = !known && message.channel != channel::kControllerState;
                                 if (lost) recomputed_.emplace(digest, message.bytes);
                                 return known;
                               }};
    const Recomputed result = recompute(run, configs_, io);
    if (!result.certain) {
      // Messages after the last one that can be computed are uncertain too.
      for (const std::string_view channel : publisher.channels) {
        if (!channel.empty()) recomputed.uncertain_from.try_emplace(channel, next[channel]);
      }
      note(fmt::format("{}: {} of {} inputs are not in the log; some of its later messages cannot be checked", run.node,
                       result.missing, result.inputs));
    }
    const int64_t unchecked = result.restored + (result.certain ? result.missing : 0);
    if (unchecked > 0) {
      note(fmt::format(
          "{}: its messages for {} of {} inputs cannot be checked: these or earlier inputs are not in the log",
          run.node, unchecked, result.inputs));
    }
    const int64_t config = run.node == "vision" && configs_.vision ? configs_.vision->digest : configs_.robot.digest;
    if (config != run.config_digest) {
      note(fmt::format("{} ran with another configuration than that of {}, or its file has changed since", run.node,
                       run.node == "vision" && configs_.vision
                           ? "--vision (default: vision.yaml beside the robot's file)"
                           : "--robot"));
    }
  }

  /// For each run, the event of its last message that was computed with all inputs present.
  static std::vector<int64_t> last_certain(std::string_view channel, const std::vector<RecordedMessage>& messages,
                                           const std::vector<RecomputedRun>& recomputed, const Digests& computed) {
    std::vector<int64_t> last(recomputed.size(), -1);
    for (const RecordedMessage& message : messages) {
      const auto found = computed.find(message.digest);
      if (found == computed.end()) continue;
      const auto uncertain = recomputed[found->second].uncertain_from.find(channel);
      const bool certain =
          uncertain == recomputed[found->second].uncertain_from.end() || message.sequence < uncertain->second;
      if (certain) last[found->second] = message.event;
    }
    return last;
  }

  /// Whether a TARGET is of another process than vision: neither its name nor its run is vision's.
  bool is_of_another_publisher(const RecordedMessage& message, const std::vector<RecomputedRun>& recomputed) const {
    const auto target = decode<target_t>(message.bytes);
    if (!target || !configs_.vision) return false;
    const auto named = [&](const auto& each) { return each.name == target->name; };
    return std::ranges::none_of(configs_.vision->targets, named) &&
           std::ranges::none_of(configs_.vision->tags, named) &&
           std::ranges::none_of(recomputed, [&](const auto& each) { return each.run->sender_run == target->run; });
  }

  void compare(const channel::Publisher& publisher, std::string_view channel,
               const std::vector<RecomputedRun>& recomputed, const Digests& computed) {
    const auto& messages = log_.messages(channel);
    if (messages.empty() || (recomputed.empty() && channel == channel::kRobotState)) return;
    Verification::Channel& sum = sum_of(channel);
    sum.messages = static_cast<int64_t>(messages.size());
    sum.computed = !recomputed.empty();
    const std::vector<int64_t> certain_until = last_certain(channel, messages, recomputed, computed);
    int64_t expected = 0;
    for (const RecordedMessage& message : messages) {
      if (computed.contains(message.digest)) {
        ++sum.equal;
        expected = message.sequence + 1;
        continue;
      }
      if (recomputed.empty()) {
        ++sum.unchecked;
        continue;
      }
      if (channel == channel::kTarget && is_of_another_publisher(message, recomputed)) {
        ++sum.unchecked;
        note("TARGET: other processes than vision sent some of the messages; these are not checked");
        continue;
      }
      size_t of = 0;
      for (size_t i = 0; i < recomputed.size(); ++i) {
        if (recomputed[i].run->first_event <= message.event) of = i;
      }
      // The position in the log decides; at the boundary the message's sequence number decides.
      const auto uncertain = recomputed[of].uncertain_from.find(channel);
      if (uncertain != recomputed[of].uncertain_from.end() && message.event > certain_until[of] &&
          (message.sequence < 0 || message.sequence >= uncertain->second)) {
        ++sum.unchecked;
        continue;
      }
      if (recomputed[of].uncomputable.contains(message.sequence) ||
          recomputed[of].restored.contains(message.sequence)) {
        ++sum.unchecked;
        continue;
      }
      ++sum.different;
      if (!result_.first || message.event < result_.first->event) {
        report(publisher, channel, *recomputed[of].run, message, expected);
      }
    }
    if (recomputed.empty()) {
      note(fmt::format("{}: this log has no NODE_INPUTS of {}; the messages are not checked", channel, publisher.node));
    }
  }

  /// Computes the run once more to find out what the message should have been.
  void report(const channel::Publisher& publisher, std::string_view channel, const RecordedRun& run,
              const RecordedMessage& message, int64_t expected) {
    std::vector<uint8_t> nearest;
    size_t fewest = SIZE_MAX;
    const Recomputation io{.find = [this](int64_t digest) { return find(digest); },
                           .recorded = [](int64_t) { return std::span<const uint8_t>(); },
                           .sent =
                               [&](const OutMessage& computed, bool) {
                                 const bool known = !log_.bytes_of(digest_of(computed.bytes)).empty();
                                 const int64_t own = sequence_in(computed.bytes);
                                 if (computed.channel != channel || (own != message.sequence && own != expected))
                                   return known;
                                 const size_t common = std::min(computed.bytes.size(), message.bytes.size());
                                 size_t different = std::max(computed.bytes.size(), message.bytes.size()) - common;
                                 for (size_t i = 0; i < common; ++i) different += computed.bytes[i] != message.bytes[i];
                                 if (different >= fewest) return known;
                                 fewest = different;
                                 nearest = computed.bytes;
                                 return known;
                               }};
    recompute(run, configs_, io);
    const MessageDifference difference =
        nearest.empty() ? MessageDifference{"message", "present", "absent"} : difference_of(message.bytes, nearest);
    record_difference(channel, publisher.node, message, difference);
  }

  /// A state that no SIM_STEP names is not the one that the robot sent, where the step after it in the log belongs to
  /// it; else its step was lost by the recorder, and it cannot be checked.
  static bool altered(const RecordedMessage& state, int64_t previous_sequence, const sim_step_t& step) {
    if (step.previous_state_digest == state.digest) return false;
    if (state.sequence == step.sequence) return true;
    if (step.previous_state_digest == 0 || previous_sequence >= step.sequence) return false;  // around a restart
    return state.sequence <= previous_sequence || state.sequence > step.sequence;
  }

  void verify_simulated_robot() {
    const auto& states = log_.messages(channel::kRobotState);
    if (!log_.runs("ideal_robot").empty() || states.empty()) return;
    RobotSimCheck check(configs_.robot, [this](int64_t digest) { return find(digest); });
    Verification::Channel& sum = sum_of(channel::kRobotState);
    sum.messages = static_cast<int64_t>(states.size());
    std::unordered_map<int64_t, sim_step_t> by_state;
    std::map<int64_t, int64_t> by_event;  // to the state's digest
    for (const RecordedMessage& message : log_.messages(channel::kSimStep)) {
      auto step = decode<sim_step_t>(message.bytes);
      if (!step || !checksum_matches(message.bytes)) continue;
      by_event[message.event] = step->state_digest;
      by_state.emplace(step->state_digest, std::move(*step));
    }
    sum.computed = !by_state.empty();
    for (size_t i = 0; i < states.size(); ++i) {
      const RecordedMessage& state = states[i];
      auto named = by_state.find(state.digest);
      if (named == by_state.end()) {
        const auto next = by_event.upper_bound(state.event);
        const bool nearby = next != by_event.end() && (i + 1 == states.size() || next->first < states[i + 1].event);
        if (!nearby || !altered(state, i > 0 ? states[i - 1].sequence : -1, by_state.at(next->second))) {
          ++sum.unchecked;
          continue;
        }
        named = by_state.find(next->second);
      }
      const auto recorded = decode<robot_state_t>(state.bytes);
      // The run of the first state is known from itself alone, and only while nothing in it was changed.
      const bool intact = recorded && named->first == state.digest;
      const auto expected = check.compute(named->second, intact ? recorded->run : 0);
      if (expected && std::ranges::equal(*expected, state.bytes)) {
        ++sum.equal;
      } else if (!expected && named->first == state.digest) {
        ++sum.unchecked;
      } else {
        ++sum.different;
        const MessageDifference difference =
            expected ? difference_of(state.bytes, *expected)
                     : MessageDifference{"SIM_STEP.state_digest", "names another message", ""};
        record_difference(channel::kRobotState, "robot_sim", state, difference);
      }
    }
    if (!sum.computed) note("ROBOT_STATE: not from the simulated robot; the messages are not checked");
  }

  const RecordedLog& log_;
  const NodeConfigs& configs_;
  Verification result_;
  std::unordered_map<int64_t, std::vector<uint8_t>> recomputed_;  // computed messages that the recorder lost
};

}  // namespace

bool Verification::nothing_checked() const {
  return std::ranges::none_of(channels, [](const auto& entry) {
    // Those with a digest of themselves are not computed.
    const bool has_checksum = std::ranges::find(kWithChecksum, entry.first) != kWithChecksum.end();
    return !has_checksum && entry.second.equal + entry.second.different > 0;
  });
}

std::string Verification::Difference::sentence() const {
  const std::string what =
      sequence >= 0 ? fmt::format("{} {}", channel, sequence) : fmt::format("a message of {}", channel);
  const std::string where = fmt::format("{} (event {}, {:.3f} s after the log's begin)", what, event, after_s);
  if (computed.empty()) return fmt::format("{}: {} {}", where, field, recorded);
  return fmt::format("{}: {} is {} in the log, and {} as recomputed by {}", where, field, recorded, computed, node);
}

Verification verify(const std::string& path, const NodeConfigs& configs, const std::function<void(double)>& progress) {
  const RecordedLog log(path, [&](double part) { progress(0.5 * part); });
  Verification result = Verifier(log, configs).verify(progress);
  if (result.first)
    result.first->after_s = (static_cast<double>(result.first->utime) - static_cast<double>(log.first_utime())) * 1e-6;
  return result;
}

}  // namespace multireach
