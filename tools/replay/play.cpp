#include "tools/replay/play.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "runtime/bus.hpp"
#include "runtime/channels.hpp"
#include "runtime/digest.hpp"
#include "runtime/message_clock.hpp"
#include "runtime/message_schema.hpp"
#include "tools/replay/message_difference.hpp"

namespace multireach {
namespace {

constexpr int64_t kResendPeriod = 30000;    // us; period of resending a step
constexpr int64_t kStepTimeout = 10000000;  // us

/// The current step of a live process, and its progress.
struct Process {
  replay_step_t step{};
  int64_t sent = 0, digest = 0;  // expected in its report at the end of the step
  bool done = false;
};

class Player : public VirtualLoop::Observer {
 public:
  Player(const PlayOptions& options, const std::vector<std::unique_ptr<Node>>& nodes)
      : options_(options), bus_(options.bus), loop_(*this) {
    add_all(loop_, nodes, options.replay);
    const int64_t replay = wall_us();
    for (const auto& node : nodes) {
      if (node->name() == "ideal_robot") continue;
      Process& process = processes_[node->name()];
      process.step.replay = replay;
      process.step.node = node->name();
      for (const channel::Publisher& publisher : channel::kPublishers) {
        if (publisher.node != node->name()) continue;
        for (const std::string_view output : publisher.channels) {
          if (output.empty()) continue;
          bus_.subscribe(output, "play",
                         [this](std::string_view channel, std::span<const uint8_t> bytes) { compare(channel, bytes); });
        }
      }
    }
    bus_.subscribe(channel::kReplayDone, "play",
                   [this](std::string_view, std::span<const uint8_t> bytes) { take_report(bytes); });
  }

  PlayResult play(Session& session, const ReplayProgress& progress) {
    const int64_t begin = monotonic_us();
    for (int k = 0; k < 2 && ok(); ++k) finish_step();  // all nodes leave their clocks, then start afresh
    const auto until_us = static_cast<int64_t>(options_.replay.until_s * 1e6);
    int64_t last_us = 0;
    const int64_t started = monotonic_us();
    for (auto input = session.next(); input && input->at_us < until_us && ok(); input = session.next()) {
      loop_.advance(input->at_us);
      const bool frame = input->channel == channel::kStereoImages || input->channel == channel::kTarget;
      if (frame) {
        finish_step();
        ++result_.frames;
        wait_until(started, input->at_us);
      }
      publish(input->channel, input->data);
      loop_.deliver(input->at_us, input->channel, input->data);
      last_us = input->at_us;
      progress(static_cast<double>(session.log().position()) / static_cast<double>(session.log().size()));
    }
    loop_.advance(std::min(until_us, last_us + kDrainTime));
    if (ok()) finish_step();
    if (ok()) end_lockstep();
    result_.span_s = static_cast<double>(last_us) * 1e-6;
    result_.took_s = static_cast<double>(monotonic_us() - begin) * 1e-6;
    return result_;
  }

  void sent(int64_t, std::string_view channel, std::span<const uint8_t> bytes) override {
    if (channel == channel::kNodeInputs) return;
    const std::string publisher(channel::publisher_of(channel));
    if (publisher.empty())
      throw std::logic_error("channel " + std::string(channel) + " has no publisher in runtime/channels.hpp");
    const auto process = processes_.find(publisher);
    if (process == processes_.end()) {
      publish(channel, bytes);  // from the ideal robot, which runs in this process
      return;
    }
    ++process->second.sent;
    process->second.digest = digest_with(process->second.digest, channel, bytes);
    remember(channel, bytes);
  }

  void consumed(const Node& node, const ConsumedInput& input) override {
    const auto process = processes_.find(node.name());
    if (process == processes_.end()) return;
    replay_step_t& step = process->second.step;
    step.before_tick.push_back(input.ticks);
    append_channel(input.channel, step.channel_name, step.channel);
    step.num_channels = static_cast<int32_t>(step.channel_name.size());
    step.digest.push_back(input.digest);
  }

  void ticked(const Node& node) override {
    const auto process = processes_.find(node.name());
    if (process != processes_.end()) ++process->second.step.ticks;
  }

 private:
  bool ok() const { return result_.failure.empty() && !interrupted(); }

  /// Keeps the messages of this step, to resend any that a process has not received.
  void remember(std::string_view channel, std::span<const uint8_t> bytes) {
    sent_messages_[digest_of(bytes)] = {channel, {bytes.begin(), bytes.end()}};
  }
  void publish(std::string_view channel, std::span<const uint8_t> bytes) {
    remember(channel, bytes);
    bus_.publish(channel, bytes);
  }

  void wait_until(int64_t started, int64_t at_us) {
    if (options_.speed <= 0) return;
    const int64_t when = started + static_cast<int64_t>(static_cast<double>(at_us) / options_.speed);
    while (ok() && monotonic_us() < when) bus_.handle_messages(when - monotonic_us(), [this] { return !ok(); });
  }

  void send_step(Process& process) {
    process.step.num_inputs = static_cast<int32_t>(process.step.digest.size());
    if (auto bytes = encode(process.step)) {
      set_checksum(*bytes);
      bus_.publish(channel::kReplayStep, *bytes);
    }
  }

  /// Sends all processes the step that was computed here, and waits until they have done it.
  void finish_step() {
    for (auto& [name, process] : processes_) {
      process.done = false;
      send_step(process);
    }
    const int64_t begin = monotonic_us();
    int64_t last_sent_us = begin;
    const auto finished = [this] {
      return !ok() || std::ranges::all_of(processes_, [](const auto& entry) { return entry.second.done; });
    };
    while (!finished()) {
      bus_.handle_messages(last_sent_us + kResendPeriod - monotonic_us(), finished);
      const int64_t now = monotonic_us();
      if (now - begin > kStepTimeout) return report_timeout();
      if (now < last_sent_us + kResendPeriod) continue;
      for (auto& [name, process] : processes_) {
        if (!process.done) send_step(process);
      }
      last_sent_us = now;
    }
    for (auto& [name, process] : processes_) {
      ++process.step.step;
      process.step.before_tick.clear();
      process.step.channel.clear();
      process.step.digest.clear();
    }
    sent_messages_.clear();
  }

  void end_lockstep() {
    for (auto& [name, process] : processes_) process.step.last = true;
    finish_step();
  }

  void report_timeout() {
    for (const auto& [name, process] : processes_) {
      if (process.done) continue;
      result_.failure =
          fmt::format("{} did not answer for {} s: is it running, with the same LCM URLs and the same configuration?",
                      name, kStepTimeout / 1000000);
      return;
    }
  }

  void take_report(std::span<const uint8_t> bytes) {
    const auto report = decode<replay_done_t>(bytes);
    const auto found = report ? processes_.find(report->node) : processes_.end();
    if (found == processes_.end()) return;
    Process& process = found->second;
    if (report->replay != process.step.replay || report->step != process.step.step) return;
    for (const int64_t digest : report->missing) {
      const auto sent_message = sent_messages_.find(digest);
      // A message from another live process is resent only once that process is done: until then it may not have been
      // sent yet.
      if (sent_message == sent_messages_.end() || (report->done || !sender_is_done(sent_message->second.channel)))
        continue;
      bus_.publish(sent_message->second.channel, sent_message->second.bytes);
      ++result_.resent;
    }
    if (!report->done) return;
    process.done = true;
    if (report->sent == process.sent && report->digest == process.digest) return;
    if (result_.failure.empty()) {
      result_.failure =
          fmt::format("{} sent other bytes than computed here: its build or its configuration differs", report->node);
    }
  }

  bool sender_is_done(std::string_view channel) const {
    const auto process = processes_.find(std::string(channel::publisher_of(channel)));
    return process == processes_.end() || process->second.done;
  }

  /// Compares a message from a process with the one computed here, and reports the first field that differs.
  void compare(std::string_view channel, std::span<const uint8_t> bytes) {
    if (sent_messages_.contains(digest_of(bytes))) return;
    const MessageSchema* schema = MessageSchemas::project().of(bytes);
    const int64_t sequence = schema ? sequence_of(*schema, bytes).value_or(-1) : -1;
    if (sequence < 0) return;
    for (const auto& [digest, sent_message] : sent_messages_) {
      if (sent_message.channel != channel || sequence_of(*schema, sent_message.bytes).value_or(-1) != sequence)
        continue;
      const MessageDifference difference = difference_of(bytes, sent_message.bytes);
      result_.failure =
          fmt::format("{} {}: {} is {} from {}, and {} when computed here", channel, sequence, difference.field,
                      difference.first, channel::publisher_of(channel), difference.second);
      return;
    }
  }

  struct SentMessage {
    std::string_view channel;
    std::vector<uint8_t> bytes;
  };

  const PlayOptions& options_;
  Bus bus_;
  VirtualLoop loop_;
  std::map<std::string, Process, std::less<>> processes_;
  std::map<int64_t, SentMessage> sent_messages_;
  PlayResult result_;
};

}  // namespace

PlayResult play(const PlayOptions& options, const ReplayProgress& progress) {
  Session session(options.replay.session, options.replay.from, options.replay.robot == ReplayRobot::kRecorded);
  const auto nodes = nodes_of(options.replay);
  Player player(options, nodes);
  catch_signals();
  return player.play(session, progress);
}

}  // namespace multireach
