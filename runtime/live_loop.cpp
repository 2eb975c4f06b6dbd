#include "runtime/live_loop.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sched.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <multireach/node_status_t.hpp>
#include <random>
#include <utility>

#include "runtime/build_id.hpp"
#include "runtime/channels.hpp"
#include "runtime/datagram_guard.hpp"
#include "runtime/digest.hpp"
#include "runtime/files.hpp"
#include "runtime/input_journal.hpp"
#include "runtime/message_clock.hpp"
#include "runtime/udpm_socket.hpp"

namespace multireach {
namespace {

volatile std::sig_atomic_t signal_received = 0;

/// A node that is further behind than this skips ticks instead of catching up.
constexpr int64_t kMaxTickDelay = 2000000;  // us
constexpr int64_t kStalled = 500000;        // us: a node this late was stopped; what waited must not set its clock back
constexpr int64_t kMaxTickBurst = 5000;     // us; longest time for ticks without handling messages
constexpr int64_t kSlowTicks = 10000;       // us: a node whose ticks are further apart than this ...
constexpr int64_t kCatchUp = 2000;          // ... what has arrived is handled first, for at most so long ...
constexpr int kLeastCaughtUp = 100;         // ... but so many messages, even where other processes take the time
constexpr int64_t kStatusPeriod = 1000000;
constexpr int64_t kStatusWork = 500;  // us: more than a status takes; it waits for a tick that is due sooner than this
constexpr int64_t kReportPeriod = 20000;
constexpr int64_t kMaxShutdown = 2000000;
constexpr int kRealTimePriority = 40;  // below that of the kernel's interrupt threads, 50
constexpr int64_t kPlayerTimeout = 30000000;
constexpr size_t kRepeatedInputs = 72;  // about a third of a second of the bridge's inputs, in case a recorder stalls

/// A random number that identifies a run.
int64_t random_run() {
  std::random_device device;
  return static_cast<int64_t>((static_cast<uint64_t>(device()) << 31) ^ device()) | 2;  // not kVirtualRun
}

/// Gives this process a fixed priority above all ordinary ones, and keeps its memory from being swapped out. LCM's
/// thread that receives gets one too: the loop waits for that thread's lock, and would wait for all ordinary processes
/// while the thread is preempted with the lock held.
void become_real_time() {
  bool priority = true;
  int error = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    const int thread = std::stoi(task.path().filename());
    sched_param parameters{};
    parameters.sched_priority = thread == gettid() ? kRealTimePriority : kRealTimePriority - 1;
    if (sched_setscheduler(thread, SCHED_FIFO, &parameters) == 0) continue;
    priority = false;
    error = errno;
  }
  const bool locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  if (!priority || !locked) {
    spdlog::warn("no {} ({}): on a busy machine periods will be missed",
                 priority ? "locked memory" : "real-time priority", strerror(priority ? errno : error));
  }
}

class LiveLoop {
 public:
  /// Without `make`, the node does not support lockstep replay.
  LiveLoop(Node& node, NodeFactory make, const LiveOptions& options)
      : node_(&node), make_(std::move(make)), options_(options), clock_(options.speed), bus_(options) {
    start_journal();
    // Other transports than multicast have no packets that could wait.
    if (options_.drain_period_us > 0 && UdpmSocket::supports(options_.control_url)) {
      socket_.emplace(options_.control_url);
    }
    for (const std::string_view channel : node.inputs()) {
      if (socket_ && !channel::on_image_group(channel)) continue;
      const auto handle = node.takes_newest(channel) ? &LiveLoop::keep_newest : &LiveLoop::receive;
      bus_.subscribe(channel, node.name(), [this, handle](std::string_view on, std::span<const uint8_t> bytes) {
        (this->*handle)(on, bytes);
      });
    }
    if (!make_ || socket_) return;
    bus_.subscribe(channel::kReplayStep, node.name(),
                   [this](std::string_view, std::span<const uint8_t> bytes) { receive_step(bytes); });
  }

  int run() {
    prctl(PR_SET_TIMERSLACK, 1);
    if (options_.real_time) become_real_time();
    start_us_ = monotonic_us();
    next_status_us_ = start_us_;
    if (node_->next_tick()) clock_.anchor(*node_->next_tick(), start_us_);
    spdlog::info("{} is running (build {})", node_->name(), kBuildId);
    if (!bus_.gate().has_key()) spdlog::info("without a --key, whoever reaches this LCM group may command the robot");
    while (!ended()) {
      const int64_t now = monotonic_us();
      poll_messages(wake_time() - now);
      if (lockstep_) {
        follow_steps();
      } else {
        compute_ticks();
      }
      if (monotonic_us() >= status_time()) publish_status();
    }
    publish_status();
    return 0;
  }

 private:
  /// Whether to leave the loop: at once, or once a node that ends by itself has ended its ticks.
  bool ended() {
    const int64_t now = monotonic_us();
    const bool over = options_.seconds > 0 && static_cast<double>(now - start_us_) > options_.seconds * 1e6;
    if (node_->finished()) return true;
    if (!interrupted() && !over) return false;
    if (lockstep_ || !node_->next_tick()) return true;
    if (!shutdown_us_) {
      const auto request = node_->shutdown_request();
      if (!request && !node_->begin_end()) return true;
      shutdown_us_ = now;
      if (request) {
        // Published for the record. The node gets it here: it must end well without a network, too.
        bus_.publish(request->channel, request->bytes);
        receive(request->channel, request->bytes);
        publish();
        shutdown_request_ = request;
      }
    }
    if (now - *shutdown_us_ <= kMaxShutdown) return false;
    spdlog::warn("ends in motion: it was not at rest {} s after it was asked to end", kMaxShutdown / 1000000);
    return true;
  }

  /// When the next tick is due, once ticks have begun.
  std::optional<int64_t> tick_time() const {
    const auto tick = lockstep_ ? std::nullopt : node_->next_tick();
    if (!tick || !clock_.anchored()) return std::nullopt;
    return due_us(*tick);
  }

  /// When to send NODE_STATUS: not just before a tick, which it would delay, but after it.
  int64_t status_time() const {
    const auto tick = tick_time();
    const bool collides = tick && *tick >= next_status_us_ && *tick - next_status_us_ < kStatusWork;
    return collides ? *tick : next_status_us_;
  }

  int64_t wake_time() const {
    int64_t wake = status_time();
    if (shutdown_us_) {
      wake = std::min(wake, monotonic_us() + kReportPeriod);
    } else if (options_.seconds > 0)
      wake = std::min(wake, start_us_ + static_cast<int64_t>(options_.seconds * 1e6) + 1);
    if (lockstep_) return std::min(wake, next_report_us_);
    return std::min(wake, tick_time().value_or(wake));
  }

  int64_t due_us(int64_t tick) const {
    return std::max(clock_.monotonic_at(tick) + node_->tick_delay_us(), asked_for_us_);
  }

  /// Sleeps until the next drain, then handles what has arrived.
  void drain_messages(int64_t timeout_us) {
    timeout_us = std::clamp<int64_t>(timeout_us, 0, options_.drain_period_us);
    const timespec timeout{timeout_us / 1000000, timeout_us % 1000000 * 1000};
    ppoll(nullptr, 0, &timeout, nullptr);  // ends early at a signal
    const auto inputs = node_->inputs();
    socket_->drain([&](const UdpmMessage& message) {
      if (std::ranges::find(inputs, message.channel) == inputs.end()) return;
      if (const auto payload = bus_.gate().incoming(message.channel, message.bytes)) receive(message.channel, *payload);
    });
    bus_.handle_messages(0, [] { return interrupted(); });  // images may have many packets: LCM puts them together
    publish();
  }

  void poll_messages(int64_t timeout_us) {
    if (socket_) return drain_messages(timeout_us);
    handle_messages(timeout_us);
    receive_newest();
    publish();
  }

  void handle_messages(int64_t timeout_us) {
    // Messages must not delay a tick. But slow ticks that are late already must not leave them in LCM's queue,
    // which drops the newest when it is full: later ticks would be computed from ever older ones.
    const int64_t begin = monotonic_us();
    const bool is_late = timeout_us < 0 && node_->tick_period_us() >= kSlowTicks;
    const int64_t patience = is_late ? kCatchUp : 0;
    int left = is_late ? kLeastCaughtUp : 0;
    bus_.handle_messages(timeout_us, [this, begin, patience, &left] {
      publish();
      if (interrupted() && !shutdown_us_) return true;
      if (newest_ && monotonic_us() >= newest_->since_us + kCatchUp) return true;
      return --left <= 0 && monotonic_us() >= std::max(wake_time(), begin) + patience;
    });
  }

  /// Keeps a message of Node::takes_newest() until no other one waits.
  void keep_newest(std::string_view channel, std::span<const uint8_t> bytes) {
    if (lockstep_) return lockstep_->receive(channel, bytes);
    if (newest_ && newest_->channel != channel) receive_newest();
    if (newest_) node_->leave_out(channel, newest_->bytes);
    const int64_t since_us = newest_ ? newest_->since_us : monotonic_us();
    newest_.emplace(Newest{std::string(channel), {bytes.begin(), bytes.end()}, since_us});
  }

  void receive_newest() {
    const auto newest = std::exchange(newest_, std::nullopt);
    if (!newest) return;
    Bus::handle_safely(node_->name(), newest->channel, [&] { receive(newest->channel, newest->bytes); });
  }

  void receive(std::string_view channel, std::span<const uint8_t> bytes) {
    if (lockstep_) return lockstep_->receive(channel, bytes);
    if (shutdown_request_ && channel == shutdown_request_->channel &&
        std::ranges::equal(bytes, shutdown_request_->bytes))
      return;  // LCM also delivers a program's own messages
    // Ticks that were missed come before a message that waited meanwhile.
    const auto due = tick_time();
    const bool skips = node_->late_ticks() == LateTicks::kSkip;
    if (skips && due) skip_missed(monotonic_us() - *due);
    const auto next = node_->next_tick();
    const int64_t delay = node_->tick_delay_us();
    const Receipt receipt = node_->receive(channel, bytes, outbox_);
    const bool stalled = skips && due && monotonic_us() - *due > kStalled;
    if (node_->next_tick() != next || node_->tick_delay_us() < delay) asked_for_us_ = monotonic_us();
    if (receipt.utime && receipt.restarts_ticks) {
      clock_.anchor(*receipt.utime, monotonic_us());
    } else if (receipt.utime && !stalled) {
      clock_.observe(*receipt.utime, monotonic_us(), node_->late_ticks() == LateTicks::kSkip);
    }
    if (journal_) journal_->record(receipt, channel, bytes);
  }

  void receive_step(std::span<const uint8_t> bytes) {
    const auto step = decode<replay_step_t>(bytes);
    if (!step || !checksum_matches(bytes) || step->node != node_->name()) return;
    if (!options_.lockstep) {
      if (!std::exchange(refused_step_, true))
        spdlog::warn("a lockstep replay is refused: this process was started without --lockstep");
      return;
    }
    if (last_report_ && step->replay == last_report_->replay) {  // the player did not receive the final report
      last_report_->step = step->step;
      if (const auto report = encode(*last_report_)) bus_.publish(channel::kReplayDone, *report);
      return;
    }
    if (!lockstep_) {
      if (step->step != 0) return;
      lockstep_.emplace(make_);
      spdlog::info("{} follows a replay in lockstep", node_->name());
    }
    const bool is_new = lockstep_->begin(*step);
    last_step_us_ = monotonic_us();
    if (is_new) reported_done_ = false;
    next_report_us_ = last_step_us_ + (is_new ? kReportPeriod : 0);
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
    if ((done && lockstep_->last()) || now - last_step_us_ > kPlayerTimeout) leave_lockstep();
  }

  void leave_lockstep() {
    last_report_ = lockstep_->report();
    lockstep_.reset();
    new_node_ = make_();
    node_ = new_node_.get();
    clock_ = MessageClock(options_.speed);
    if (node_->next_tick()) clock_.anchor(*node_->next_tick(), monotonic_us());
    start_journal();
    spdlog::info("{} follows the clock again", node_->name());
  }

  void start_journal() {
    node_->set_run(random_run());
    if (const auto digest = node_->config_digest())
      journal_.emplace(node_->name(), wall_us(), node_->run(), *digest, kRepeatedInputs);
  }

  /// How many whole periods fit into so many microseconds.
  int64_t missed_by(int64_t behind) const {
    return static_cast<int64_t>(static_cast<double>(behind) * options_.speed /
                                static_cast<double>(node_->tick_period_us()));
  }

  /// LateTicks::kSkip, with the next tick so late: skips those that were missed. Returns whether there were any.
  bool skip_missed(int64_t behind) {
    const int64_t missed = missed_by(behind);
    if (missed <= 0) return false;
    node_->count_lateness(behind);
    node_->count_late(missed);
    node_->skip_ticks(missed);
    if (journal_) journal_->record_skip(missed);
    if (behind > kMaxTickDelay && node_->next_tick()) clock_.anchor(*node_->next_tick(), monotonic_us());
    return true;
  }

  void compute_ticks() {
    const int64_t begin = monotonic_us();
    while (const auto tick = node_->finished() ? std::nullopt : node_->next_tick()) {
      const int64_t now = monotonic_us();
      if (now - begin > kMaxTickBurst) return;  // ticks slower than their period must not starve the messages
      if (!clock_.anchored()) clock_.anchor(*tick, now);
      const int64_t behind = now - due_us(*tick);
      if (behind < 0 || (interrupted() && !shutdown_us_)) return;
      const LateTicks policy = node_->late_ticks();
      if (policy == LateTicks::kSkip && skip_missed(behind)) continue;
      node_->count_lateness(behind);
      if (missed_by(behind) > 0) {
        node_->count_late(policy == LateTicks::kCompute ? 1 : missed_by(behind));
        if (policy == LateTicks::kPause || behind > kMaxTickDelay) clock_.anchor(*tick, now);
      }
      node_->tick(outbox_);
      if (journal_) journal_->ticked();
      publish();
    }
  }

  void publish() {
    // NODE_INPUTS goes out before the messages that depend on it, so that no recorded output lacks its inputs. In
    // lockstep, the outbox already contains it.
    const bool publishes_inputs = !outbox_.empty() && journal_ && !lockstep_;
    if (publishes_inputs && journal_->next_message(inputs_)) bus_.publish(channel::kNodeInputs, inputs_);
    for (const OutMessage& message : outbox_) bus_.publish(message.channel, message.bytes);
    node_->reuse(outbox_);
  }

  /// Says for how long a node that has received messages has received none.
  std::string silence(const NodeCounters& counters) {
    constexpr int64_t kSilent = 3'000'000;  // us
    const int64_t now = monotonic_us();
    if (std::exchange(received_, counters.received + counters.refused) != counters.received + counters.refused)
      received_us_ = now;
    if (counters.received == 0 || now - received_us_ < kSilent) return {};
    return fmt::format("; nothing received for {} s", (now - received_us_) / 1'000'000);
  }

  void publish_status() {
    if (dropped_datagrams() > 0 && !std::exchange(dropped_datagram_, true))
      spdlog::warn("malformed LCM datagrams arrive on this group and are dropped");
    const NodeCounters& counters = lockstep_ ? lockstep_->node().counters() : node_->counters();
    node_status_t status;
    status.utime = wall_us();
    status.uptime_us = monotonic_us() - start_us_;
    status.node = node_->name();
    status.build_id = kBuildId;
    status.state = (lockstep_ ? "in lockstep" : node_->state()) + silence(counters) + text_of(bus_.gate().refused());
    status.received = counters.received;
    status.dropped = counters.dropped;
    status.refused = counters.refused + dropped_datagrams() + bus_.gate().total_refused();
    std::ranges::copy(counters.lateness, status.lateness);
    status.late = counters.late;
    status.limited = counters.limited;
    status.sent = counters.sent;
    if (auto bytes = encode(status)) {
      set_checksum(*bytes);
      bus_.publish(channel::kNodeStatus, *bytes);
    }
    next_status_us_ = std::max(next_status_us_ + kStatusPeriod, monotonic_us());
  }

  struct Newest {
    std::string channel;
    std::vector<uint8_t> bytes;
    int64_t since_us;  // when the first of those that it replaces was there
  };

  Node* node_;
  NodeFactory make_;
  std::unique_ptr<Node> new_node_;  // the node made after a lockstep replay has ended
  std::optional<Lockstep> lockstep_;
  int64_t last_step_us_ = 0, next_report_us_ = 0;
  bool reported_done_ = false;
  std::optional<replay_done_t> last_report_;  // final report of the previous replay
  LiveOptions options_;
  MessageClock clock_;
  Bus bus_;
  std::optional<UdpmSocket> socket_;  // instead of subscriptions, with a drain period
  std::optional<InputJournal> journal_;
  int64_t received_ = 0, received_us_ = 0;  // messages until the last status, and when there was a new one
  std::optional<Newest> newest_;            // to be received once no newer one waits
  Outbox outbox_;
  std::vector<uint8_t> inputs_;  // NODE_INPUTS
  int64_t start_us_ = 0, next_status_us_ = 0;
  int64_t asked_for_us_ = INT64_MIN;                      // when a message brought the next tick forward, last
  std::optional<int64_t> shutdown_us_;                    // when the node was asked to end ...
  std::optional<OutMessage> shutdown_request_;            // ... and how
  bool refused_step_ = false, dropped_datagram_ = false;  // said once
};

}  // namespace

void catch_signals() {
  struct sigaction action = {};
  action.sa_handler = [](int number) { signal_received = number; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction hang_up = {};  // of the terminal; nohup ignores it
  if (sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

bool interrupted() {
  return signal_received != 0;
}

int run_live(Node& node, const LiveOptions& options) {
  catch_signals();
  return LiveLoop(node, nullptr, options).run();
}

int run_live(const NodeFactory& make, const LiveOptions& options) {
  catch_signals();
  const std::unique_ptr<Node> node = make();
  return LiveLoop(*node, make, options).run();
}

}  // namespace multireach
