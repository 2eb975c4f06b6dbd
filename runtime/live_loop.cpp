#include "runtime/live_loop.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <lcm/lcm-cpp.hpp>
#include <multireach/node_status_t.hpp>

#include "runtime/build_id.hpp"
#include "runtime/channels.hpp"
#include "runtime/digest.hpp"
#include "runtime/files.hpp"
#include "runtime/input_journal.hpp"
#include "runtime/message_clock.hpp"

namespace multireach {
namespace {

volatile std::sig_atomic_t signal_received = 0;

/// A node that fell further behind than this does not catch up tick by tick.
constexpr int64_t kHopeless = 2000000;  // us
constexpr int64_t kLongestTurn = 5000;  // us
constexpr int64_t kStatusPeriod = 1000000;
constexpr size_t kRepeatedInputs = 32;  // of every node about a second, should a recorder stall that long

/// With room for a burst in the kernel: the default drops most of a stream of raw images.
std::string with_receive_buffer(const std::string& url) {
  if (!url.starts_with("udpm://") || url.find("recv_buf_size") != std::string::npos) return url;
  return url + (url.find('?') == std::string::npos ? "?" : "&") + "recv_buf_size=4194304";
}

void require_good(lcm::LCM& bus, const std::string& url) {
  if (bus.good()) return;
  throw InputError(
      "LCM cannot be started on '" + url +
      "'; without a network, multicast needs a route:  ip link set lo up; ip route add 224.0.0.0/4 dev lo");
}

class LiveLoop {
 public:
  LiveLoop(Node& node, const LiveOptions& options)
      : node_(node),
        options_(options),
        clock_(options.speed),
        control_(with_receive_buffer(options.control_url)),
        images_(with_receive_buffer(options.image_url)) {
    require_good(control_, options.control_url);
    require_good(images_, options.image_url);
    if (const auto digest = node.replayable()) journal_.emplace(node.name(), wall_us(), *digest, kRepeatedInputs);
    for (const std::string_view channel : node.inputs()) {
      bus_of(channel).subscribe(std::string(channel), &LiveLoop::handle, this)->setQueueCapacity(1000);
    }
  }

  int run() {
    prctl(PR_SET_TIMERSLACK, 1);
    start_us_ = monotonic_us();
    next_status_us_ = start_us_;
    if (node_.next_tick()) clock_.anchor(*node_.next_tick(), start_us_);
    spdlog::info("{} is running (build {})", node_.name(), kBuildId);
    while (!interrupted() && !node_.finished()) {
      const int64_t now = monotonic_us();
      if (options_.seconds > 0 && static_cast<double>(now - start_us_) > options_.seconds * 1e6) break;
      take_messages(wake_time() - now);
      compute_ticks();
      if (monotonic_us() >= next_status_us_) publish_status();
    }
    publish_status();
    return 0;
  }

 private:
  lcm::LCM& bus_of(std::string_view channel) { return channel::on_image_group(channel) ? images_ : control_; }

  int64_t wake_time() const {
    int64_t wake = next_status_us_;
    if (options_.seconds > 0) wake = std::min(wake, start_us_ + static_cast<int64_t>(options_.seconds * 1e6) + 1);
    const auto tick = node_.next_tick();
    if (tick && clock_.anchored()) wake = std::min(wake, clock_.monotonic_at(*tick));
    return wake;
  }

  void take_messages(int64_t timeout_us) {
    std::array<pollfd, 2> fds{{{control_.getFileno(), POLLIN, 0}, {images_.getFileno(), POLLIN, 0}}};
    timeout_us = std::max<int64_t>(timeout_us, 0);
    timespec timeout{timeout_us / 1000000, timeout_us % 1000000 * 1000};
    while (ppoll(fds.data(), fds.size(), &timeout, nullptr) > 0 && !interrupted()) {
      if (fds[0].revents) control_.handle();
      if (fds[1].revents) images_.handle();
      publish();
      timeout = {0, 0};
      if (monotonic_us() >= wake_time()) break;  // a flood of messages must not starve the ticks
    }
  }

  void handle(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
    // An exception must not leave an LCM handler: the next handle() would abort.
    try {
      const std::span bytes(static_cast<const uint8_t*>(buffer->data), buffer->data_size);
      const Receipt receipt = node_.receive(channel, bytes, outbox_);
      if (receipt.utime) clock_.observe(*receipt.utime, monotonic_us());
      if (journal_) journal_->took(receipt, channel, bytes);
    } catch (const std::exception& error) {
      spdlog::error("{}: a message on {} could not be handled: {}", node_.name(), channel, error.what());
    }
  }

  void compute_ticks() {
    const int64_t begin = monotonic_us();
    while (const auto tick = node_.next_tick()) {
      const int64_t now = monotonic_us();
      if (now - begin > kLongestTurn) return;  // ticks that are too slow for their period must not starve the messages
      if (!clock_.anchored()) clock_.anchor(*tick, now);
      const int64_t behind = now - clock_.monotonic_at(*tick);
      if (behind < 0 || interrupted()) return;
      if (behind > kHopeless) clock_.anchor(*tick, now);
      if (static_cast<double>(behind) * options_.speed > static_cast<double>(node_.tick_period_us()))
        node_.count_late();
      node_.tick(outbox_);
      if (journal_) journal_->ticked();
      publish();
    }
  }

  void publish() {
    // What a message depends on is said before it, so that no message is ever without.
    if (const auto news = !outbox_.empty() && journal_ ? journal_->news() : std::nullopt) {
      control_.publish(std::string(channel::kNodeInputs), news->data(), static_cast<unsigned>(news->size()));
    }
    for (const OutMessage& message : outbox_) {
      bus_of(message.channel).publish(std::string(message.channel), message.bytes.data(), message.bytes.size());
    }
    outbox_.clear();
  }

  void publish_status() {
    const NodeCounters& counters = node_.counters();
    node_status_t status;
    status.utime = wall_us();
    status.uptime_us = monotonic_us() - start_us_;
    status.node = node_.name();
    status.build_id = kBuildId;
    status.state = node_.state();
    status.received = counters.received;
    status.dropped = counters.dropped;
    status.refused = counters.refused;
    status.late = counters.late;
    status.limited = counters.limited;
    status.sent = counters.sent;
    if (auto bytes = encode(status)) {
      seal(*bytes);
      control_.publish(std::string(channel::kNodeStatus), bytes->data(), static_cast<unsigned>(bytes->size()));
    }
    next_status_us_ = std::max(next_status_us_ + kStatusPeriod, monotonic_us());
  }

  Node& node_;
  LiveOptions options_;
  MessageClock clock_;
  lcm::LCM control_, images_;
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
  return LiveLoop(node, options).run();
}

}  // namespace multireach
