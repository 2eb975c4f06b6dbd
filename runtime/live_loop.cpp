#include "runtime/live_loop.hpp"

#include <spdlog/spdlog.h>
#include <sys/prctl.h>

#include <algorithm>
#include <csignal>
#include <multireach/node_status_t.hpp>

#include "runtime/build_id.hpp"
#include "runtime/bus.hpp"
#include "runtime/channels.hpp"
#include "runtime/digest.hpp"
#include "runtime/files.hpp"
#include "runtime/input_journal.hpp"
#include "runtime/message_clock.hpp"

namespace multireach {
namespace {

volatile std::sig_atomic_t signal_received = 0;

/// A node that is further behind than this skips ticks instead of catching up.
constexpr int64_t kHopeless = 2000000;  // us
constexpr int64_t kLongestTurn = 5000;  // us; longest time for ticks without handling messages
constexpr int64_t kStatusPeriod = 1000000;
constexpr int64_t kReportPeriod = 20000;
constexpr int64_t kPlayerIsGone = 30000000;
constexpr size_t kRepeatedInputs = 32;  // about one second of any node's inputs, in case a recorder stalls

class LiveLoop {
 public:
  /// Without `make`, the node does not support lockstep replay.
  LiveLoop(Node& node, NodeMaker make, const LiveOptions& options)
      : node_(&node),
        make_(std::move(make)),
        options_(options),
        clock_(options.speed),
        bus_(options.control_url, options.image_url) {
    start_journal();
    for (const std::string_view channel : node.inputs()) {
      bus_.subscribe(channel, node.name(),
                     [this](std::string_view on, std::span<const uint8_t> bytes) { take(on, bytes); });
    }
    if (!make_) return;
    bus_.subscribe(channel::kReplayStep, node.name(),
                   [this](std::string_view, std::span<const uint8_t> bytes) { take_step(bytes); });
  }

  int run() {
    prctl(PR_SET_TIMERSLACK, 1);
    start_us_ = monotonic_us();
    next_status_us_ = start_us_;
    if (node_->next_tick()) clock_.anchor(*node_->next_tick(), start_us_);
    spdlog::info("{} is running (build {})", node_->name(), kBuildId);
    while (!interrupted() && !node_->finished()) {
      const int64_t now = monotonic_us();
      if (options_.seconds > 0 && static_cast<double>(now - start_us_) > options_.seconds * 1e6) break;
      take_messages(wake_time() - now);
      if (lockstep_) {
        follow_steps();
      } else {
        compute_ticks();
      }
      if (monotonic_us() >= next_status_us_) publish_status();
    }
    publish_status();
    return 0;
  }

 private:
  int64_t wake_time() const {
    int64_t wake = next_status_us_;
    if (options_.seconds > 0) wake = std::min(wake, start_us_ + static_cast<int64_t>(options_.seconds * 1e6) + 1);
    if (lockstep_) return std::min(wake, next_report_us_);
    const auto tick = node_->next_tick();
    if (tick && clock_.anchored()) wake = std::min(wake, clock_.monotonic_at(*tick));
    return wake;
  }

  void take_messages(int64_t timeout_us) {
    bus_.handle_messages(timeout_us, [this] {
      publish();
      // Too many messages must not delay the ticks.
      return interrupted() || monotonic_us() >= wake_time();
    });
  }

  void take(std::string_view channel, std::span<const uint8_t> bytes) {
    if (lockstep_) return lockstep_->receive(channel, bytes);
    const Receipt receipt = node_->receive(channel, bytes, outbox_);
    if (receipt.utime) clock_.observe(*receipt.utime, monotonic_us());
    if (journal_) journal_->took(receipt, channel, bytes);
  }

  void take_step(std::span<const uint8_t> bytes) {
    const auto step = decode<replay_step_t>(bytes);
    if (!step || !sealed(bytes) || step->node != node_->name()) return;
    if (left_ && step->replay == left_->replay) {  // the player did not receive the final report
      left_->step = step->step;
      if (const auto report = encode(*left_)) bus_.publish(channel::kReplayDone, *report);
      return;
    }
    if (!lockstep_) {
      if (step->step != 0) return;
      lockstep_.emplace(make_);
      spdlog::info("{} follows a replay in lockstep", node_->name());
    }
    const bool is_new = lockstep_->begin(*step);
    stepped_us_ = monotonic_us();
    if (is_new) reported_done_ = false;
    next_report_us_ = stepped_us_ + (is_new ? kReportPeriod : 0);
  }

  /// Computes the current step and reports when it is done. Until then, it periodically reports which messages are
  /// missing.
  void follow_steps() {
    while (lockstep_->advance(outbox_) && !interrupted()) publish();
    publish();
    const int64_t now = monotonic_us();
    const bool done = lockstep_->done();
    if ((done && !reported_done_) || now >= next_report_us_) {
      if (const auto report = encode(lockstep_->report())) bus_.publish(channel::kReplayDone, *report);
      next_report_us_ = done ? INT64_MAX : now + kReportPeriod;
    }
    reported_done_ = done;
    if ((done && lockstep_->last()) || now - stepped_us_ > kPlayerIsGone) leave_lockstep();
  }

  void leave_lockstep() {
    left_ = lockstep_->report();
    lockstep_.reset();
    own_ = make_();
    node_ = own_.get();
    clock_ = MessageClock(options_.speed);
    if (node_->next_tick()) clock_.anchor(*node_->next_tick(), monotonic_us());
    start_journal();
    spdlog::info("{} follows the clock again", node_->name());
  }

  void start_journal() {
    if (const auto digest = node_->replayable()) journal_.emplace(node_->name(), wall_us(), *digest, kRepeatedInputs);
  }

  void compute_ticks() {
    const int64_t begin = monotonic_us();
    while (const auto tick = node_->next_tick()) {
      const int64_t now = monotonic_us();
      if (now - begin > kLongestTurn) return;  // ticks slower than their period must not starve the messages
      if (!clock_.anchored()) clock_.anchor(*tick, now);
      const int64_t behind = now - clock_.monotonic_at(*tick);
      if (behind < 0 || interrupted()) return;
      if (behind > kHopeless) clock_.anchor(*tick, now);
      if (static_cast<double>(behind) * options_.speed > static_cast<double>(node_->tick_period_us()))
        node_->count_late();
      node_->tick(outbox_);
      if (journal_) journal_->ticked();
      publish();
    }
  }

  void publish() {
    // NODE_INPUTS goes out before the messages that depend on it, so that no recorded output lacks its inputs. In
    // lockstep, the outbox already contains it.
    const bool says = !outbox_.empty() && journal_ && !lockstep_;
    if (const auto news = says ? journal_->news() : std::nullopt) bus_.publish(channel::kNodeInputs, *news);
    for (const OutMessage& message : outbox_) bus_.publish(message.channel, message.bytes);
    outbox_.clear();
  }

  void publish_status() {
    const NodeCounters& counters = lockstep_ ? lockstep_->node().counters() : node_->counters();
    node_status_t status;
    status.utime = wall_us();
    status.uptime_us = monotonic_us() - start_us_;
    status.node = node_->name();
    status.build_id = kBuildId;
    status.state = lockstep_ ? "in lockstep" : node_->state();
    status.received = counters.received;
    status.dropped = counters.dropped;
    status.refused = counters.refused;
    status.late = counters.late;
    status.limited = counters.limited;
    status.sent = counters.sent;
    if (auto bytes = encode(status)) {
      seal(*bytes);
      bus_.publish(channel::kNodeStatus, *bytes);
    }
    next_status_us_ = std::max(next_status_us_ + kStatusPeriod, monotonic_us());
  }

  Node* node_;
  NodeMaker make_;
  std::unique_ptr<Node> own_;  // the node made after a lockstep replay has ended
  std::optional<Lockstep> lockstep_;
  int64_t stepped_us_ = 0, next_report_us_ = 0;
  bool reported_done_ = false;
  std::optional<replay_done_t> left_;  // final report of the previous replay
  LiveOptions options_;
  MessageClock clock_;
  Bus bus_;
  std::optional<InputJournal> journal_;
  Outbox outbox_;
  int64_t start_us_ = 0, next_status_us_ = 0;
};

}  // namespace

void catch_signals() {
  struct sigaction action = {};
  action.sa_handler = [](int number) { signal_received = number; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() {
  return signal_received != 0;
}

int run_live(Node& node, const LiveOptions& options) {
  catch_signals();
  return LiveLoop(node, nullptr, options).run();
}

int run_live(const NodeMaker& make, const LiveOptions& options) {
  catch_signals();
  const std::unique_ptr<Node> node = make();
  return LiveLoop(*node, make, options).run();
}

}  // namespace multireach
