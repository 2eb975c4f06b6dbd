#include "tools/replay/verify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <multireach/node_inputs_t.hpp>
#include <unordered_map>

#include "runtime/channels.hpp"
#include "runtime/digest.hpp"
#include "runtime/program.hpp"
#include "tools/replay/message_difference.hpp"
#include "tools/replay/robot_sim_check.hpp"

namespace multireach {
namespace {

/// Nodes in the order in which they depend on one another, and what they send. The first channel counts its ticks.
struct Publisher {
  std::string_view node;
  std::vector<std::string_view> channels;
};
const std::vector<Publisher>& publishers() {
  static const std::vector<Publisher> kPublishers{{"vision", {channel::kTarget}},
                                                  {"controller", {channel::kJointSetpoint, channel::kControllerState}},
                                                  {"bridge", {channel::kJointCommand}},
                                                  {"ideal_robot", {channel::kRobotState}}};
  return kPublishers;
}

/// A recorder may have lost so many messages in one place and no more: a larger number is a damaged one.
constexpr int64_t kLongestLoss = 200000;

class Verifier {
 public:
  Verifier(const RecordedLog& log, const NodeConfigs& configs) : log_(log), configs_(configs) {}

  Verification verify(const std::function<void(double)>& progress) {
    for (size_t i = 0; i < publishers().size(); ++i) {
      verify_node(publishers()[i]);
      progress(0.5 + 0.5 * static_cast<double>(i + 1) / static_cast<double>(publishers().size()));
    }
    verify_simulated_robot();
    for (const std::string_view channel : {channel::kNodeInputs, channel::kNodeStatus}) {
      Verification::Channel& sum = sum_of(channel);
      sum.equal = sum.messages = log_.whole(channel);
      sum.computed = true;
    }
    for (const auto& [channel, message] : log_.broken()) {
      Verification::Channel& sum = sum_of(channel);
      ++sum.messages;
      ++sum.different;
      differs({.channel = channel,
               .node = "",
               .field = "check",
               .recorded = "does not fit the rest of the message, or what others say",
               .computed = "",
               .event = message.event,
               .utime = message.utime});
    }
    for (const auto& [node, build] : log_.builds()) {
      if (build != this_build()) note(fmt::format("recorded by build {}; this is build {}", build, this_build()));
    }
    return std::move(result_);
  }

 private:
  using Digests = std::unordered_map<int64_t, int64_t>;  // of computed messages, to the run's number

  Verification::Channel& sum_of(std::string_view channel) { return result_.channels[std::string(channel)]; }

  void note(const std::string& sentence) {
    if (std::ranges::find(result_.notes, sentence) == result_.notes.end()) result_.notes.push_back(sentence);
  }

  void differs(Verification::Difference difference) {
    if (!result_.first || difference.event < result_.first->event) result_.first = std::move(difference);
  }

  std::span<const uint8_t> find(int64_t digest) const {
    const auto bytes = log_.bytes_of(digest);
    if (!bytes.empty()) return bytes;
    const auto again = recomputed_.find(digest);
    return again == recomputed_.end() ? std::span<const uint8_t>() : std::span<const uint8_t>(again->second);
  }

  /// How often a run ticked, by the messages that the log has between its first words and those of the next run.
  int64_t ticks_of(const RecordedRun& run, const RecordedRun* next, std::string_view channel) const {
    std::vector<int64_t> sequences;
    for (const RecordedMessage& message : log_.messages(channel)) {
      if (message.event >= run.first_event && (!next || message.event < next->first_event)) {
        sequences.push_back(message.sequence);
      }
    }
    std::ranges::sort(sequences);
    int64_t ticks = 0;
    for (const auto& input : run.inputs) {
      if (input) ticks = std::max(ticks, input->ticks);
    }
    for (const int64_t sequence : sequences) {
      if (sequence - ticks > kLongestLoss) break;
      ticks = std::max(ticks, sequence + 1);
    }
    return ticks;
  }

  struct Played {
    const RecordedRun* run;
    const RecordedRun* next;
    int64_t ticks;
    std::map<std::string_view, int64_t> certain_until;  // sequence from which on an input was missing
  };

  void verify_node(const Publisher& publisher) {
    const auto runs = log_.runs(publisher.node);
    std::map<std::string_view, Digests> computed;
    std::vector<Played> played;
    for (size_t i = 0; i < runs.size(); ++i) {
      const RecordedRun* next = i + 1 < runs.size() ? runs[i + 1] : nullptr;
      int64_t ticks = 0;
      for (const std::string_view channel : publisher.channels) {
        ticks = std::max(ticks, ticks_of(*runs[i], next, channel));
      }
      played.push_back({runs[i], next, ticks, {}});
      play(played.back(), static_cast<int64_t>(i), publisher.channels, computed);
    }
    for (const std::string_view channel : publisher.channels) compare(publisher, channel, played, computed[channel]);
  }

  void play(Played& played, int64_t number, const std::vector<std::string_view>& channels,
            std::map<std::string_view, Digests>& computed) {
    const RecordedRun& run = *played.run;
    std::map<std::string_view, int64_t> sent;
    const Recomputed result = recompute(
        run, configs_, played.ticks, [this](int64_t digest) { return find(digest); },
        [&](const OutMessage& message, bool certain) {
          const int64_t digest = digest_of(message.bytes);
          computed[message.channel].emplace(digest, number);
          const int64_t sequence = sent[message.channel]++;
          if (!certain) played.certain_until.try_emplace(message.channel, sequence);
          const bool input = message.channel == channel::kTarget || message.channel == channel::kJointSetpoint;
          const bool kept = input || message.channel == channel::kJointCommand;
          if (kept && log_.bytes_of(digest).empty()) recomputed_.emplace(digest, message.bytes);
          if (message.channel == channel::kJointCommand) commands_.add(run.first_event, sequence, digest);
        });
    if (result.missing > 0) {
      // What it sent beyond what can be computed is as uncertain.
      for (const std::string_view channel : channels) played.certain_until.try_emplace(channel, sent[channel]);
      note(
          fmt::format("{}: {} of {} messages that it took in are not in the log; what it sent afterwards cannot all be "
                      "checked",
                      run.node, result.missing, result.inputs));
    }
    const int64_t config = run.node == "vision" && configs_.vision ? configs_.vision->digest : configs_.robot.digest;
    if (config != run.config_digest) {
      note(fmt::format("{} ran with another configuration than the one given here, or its file has changed since",
                       run.node));
    }
  }

  void compare(const Publisher& publisher, std::string_view channel, const std::vector<Played>& played,
               const Digests& computed) {
    const auto& messages = log_.messages(channel);
    if (messages.empty() || (played.empty() && channel == channel::kRobotState)) return;
    Verification::Channel& sum = sum_of(channel);
    sum.messages = static_cast<int64_t>(messages.size());
    sum.computed = !played.empty();
    int64_t expected = 0;
    for (const RecordedMessage& message : messages) {
      if (computed.contains(message.digest)) {
        ++sum.equal;
        expected = message.sequence + 1;
        continue;
      }
      if (played.empty()) {
        ++sum.unchecked;
        continue;
      }
      const Played* of = &played.front();
      for (const Played& one : played) {
        if (one.run->first_event <= message.event) of = &one;
      }
      const auto uncertain = of->certain_until.find(channel);
      if (uncertain != of->certain_until.end() && std::max(message.sequence, expected) >= uncertain->second) {
        ++sum.unchecked;
        continue;
      }
      ++sum.different;
      if (!result_.first || message.event < result_.first->event) report(publisher, channel, *of, message, expected);
    }
    if (played.empty()) {
      note(fmt::format("{}: no {} in this log says that it made them; they are taken as they are", channel,
                       publisher.node));
    }
  }

  /// Computes the run once more to find what the message should have been.
  void report(const Publisher& publisher, std::string_view channel, const Played& played,
              const RecordedMessage& message, int64_t expected) {
    std::vector<uint8_t> nearest;
    size_t fewest = SIZE_MAX;
    int64_t sequence = 0;
    recompute(
        *played.run, configs_, played.ticks, [this](int64_t digest) { return find(digest); },
        [&](const OutMessage& computed, bool) {
          if (computed.channel != channel) return;
          const int64_t own = sequence++;
          if (own != message.sequence && own != expected) return;
          const size_t common = std::min(computed.bytes.size(), message.bytes.size());
          size_t different = std::max(computed.bytes.size(), message.bytes.size()) - common;
          for (size_t i = 0; i < common; ++i) different += computed.bytes[i] != message.bytes[i];
          if (different >= fewest) return;
          fewest = different;
          nearest = computed.bytes;
        });
    const MessageDifference place =
        nearest.empty() ? MessageDifference{"all of it", "a message", "none: the node sent no such message"}
                        : difference_of(message.bytes, nearest);
    differs({.channel = std::string(channel),
             .node = std::string(publisher.node),
             .field = place.field,
             .recorded = place.first,
             .computed = place.second,
             .event = message.event,
             .sequence = message.sequence,
             .utime = message.utime});
  }

  void verify_simulated_robot() {
    if (!log_.runs("ideal_robot").empty() || log_.messages(channel::kRobotState).empty()) return;
    RobotSimCheck check(configs_.robot, commands_, [this](int64_t digest) { return find(digest); });
    Verification::Channel& sum = sum_of(channel::kRobotState);
    sum.messages = static_cast<int64_t>(log_.messages(channel::kRobotState).size());
    for (const RecordedMessage& message : log_.messages(channel::kRobotState)) {
      const auto outcome = check.next(message);
      sum.computed = sum.computed || outcome.simulated;
      if (outcome.equal) {
        ++sum.equal;
      } else if (!outcome.expected && !outcome.broken) {
        ++sum.unchecked;
      } else {
        ++sum.different;
        const MessageDifference place = outcome.expected && !std::ranges::equal(message.bytes, *outcome.expected)
                                            ? difference_of(message.bytes, *outcome.expected)
                                            : MessageDifference{"check", "does not fit the rest of the message", ""};
        differs({.channel = std::string(channel::kRobotState),
                 .node = "robot_sim",
                 .field = place.field,
                 .recorded = place.first,
                 .computed = place.second,
                 .event = message.event,
                 .sequence = message.sequence,
                 .utime = message.utime});
      }
    }
    if (!sum.computed) note("ROBOT_STATE: not from the simulated robot; they are taken as they are");
  }

  const RecordedLog& log_;
  const NodeConfigs& configs_;
  Verification result_;
  std::unordered_map<int64_t, std::vector<uint8_t>> recomputed_;  // that the recorder lost
  ComputedCommands commands_;
};

}  // namespace

std::string Verification::Difference::sentence() const {
  const std::string what =
      sequence >= 0 ? fmt::format("{} {}", channel, sequence) : fmt::format("a message of {}", channel);
  const std::string where = fmt::format("{} (event {}, {:.3f} s after the log's begin)", what, event, after_s);
  if (computed.empty()) return fmt::format("{}: {} {}", where, field, recorded);
  return fmt::format("{}: {} is {} in the log, and {} when {} computes it again", where, field, recorded, computed,
                     node);
}

Verification verify(const std::string& path, const NodeConfigs& configs, const std::function<void(double)>& progress) {
  const RecordedLog log(path, [&](double part) { progress(0.5 * part); });
  Verification result = Verifier(log, configs).verify(progress);
  if (result.first) result.first->after_s = static_cast<double>(result.first->utime - log.first_utime()) * 1e-6;
  return result;
}

}  // namespace multireach
