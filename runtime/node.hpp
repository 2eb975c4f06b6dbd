#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/digest.hpp"
#include "runtime/message.hpp"

namespace multireach {

/// A message to be published.
struct OutMessage {
  std::string_view channel;  // one of runtime/channels.hpp
  std::vector<uint8_t> bytes;
};
using Outbox = std::vector<OutMessage>;

/// Counters for NODE_STATUS, since the node's start.
struct NodeCounters {
  int64_t received = 0;  ///< messages decoded
  int64_t dropped = 0;   ///< messages lost, counted from gaps in the sequence numbers
  int64_t refused = 0;   ///< messages that could not be decoded or were invalid
  int64_t late = 0;      ///< ticks computed more than one period after their nominal time; messages of leave_out()
  int64_t limited = 0;   ///< outputs changed by a limit
  int64_t sent = 0;      ///< messages published
  /// Ticks by how late they began, see bin_of_lateness().
  static constexpr int kLatenessBins = 12;
  std::array<int64_t, kLatenessBins> lateness{};
};

/// The bin of a tick that began `us` microseconds late: 0 for less than 16, 1 for less than 32, and so on.
constexpr size_t bin_of_lateness(int64_t us) {
  const auto bin = static_cast<size_t>(std::bit_width(static_cast<uint64_t>(us > 0 ? us : 0) / 16));
  return bin < NodeCounters::kLatenessBins ? bin : NodeCounters::kLatenessBins - 1;
}

/// How a received message affected the node.
struct Receipt {
  enum class Effect {
    kNone,      ///< the node's outputs do not depend on it
    kConsumed,  ///< the node's state depends on it
    kReplaces,  ///< as kConsumed, and an earlier message of this channel since the last tick no longer has any effect
  };
  Effect effect = Effect::kNone;
  std::optional<int64_t> utime{};  ///< time in the message that the ticks are aligned to, if any
  int64_t sequence = -1;           ///< the message's sequence number; -1 if it has none
  bool restarts_ticks = false;     ///< the ticks begin again at `utime`, which is now
};

/// What a node does about ticks that could not be computed in time.
enum class LateTicks {
  kCompute,  ///< computes them late, for their nominal times
  kSkip,     ///< skips them, see Node::skip_ticks: at most one tick in a period of the clock
  kPause,    ///< its time stands still meanwhile
};

/// A processing stage with its messages: timed events in, messages out. It uses neither LCM nor a clock, so the same
/// object runs live, in a replay and in a test.
class Node {
 public:
  virtual ~Node() = default;

  virtual std::string name() const = 0;
  virtual std::vector<std::string_view> inputs() const = 0;
  /// Handles a message on one of the inputs. The node's outputs are a function of the messages that had an effect,
  /// their order, and their order relative to its ticks; a record of these is enough to compute the outputs again.
  virtual Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) = 0;
  /// Whether, live, only the newest of the messages that wait on this channel is handled: those of a sensor that may be
  /// faster than the node.
  virtual bool takes_newest(std::string_view) const { return false; }
  /// Such a message is left out, for a newer one waits. It affects nothing but the node's counters.
  virtual void leave_out(std::string_view, std::span<const uint8_t>) { ++counters_.late; }
  /// The nominal time of the next tick, in message time; nothing while the node does not tick.
  virtual std::optional<int64_t> next_tick() const { return std::nullopt; }
  virtual int64_t tick_period_us() const { return 0; }
  /// Live, a tick is computed this long after a message of its time arrives at the earliest, so that the messages of
  /// that time are there. Once they are, the node may say 0.
  virtual int64_t tick_delay_us() const { return 0; }
  virtual void tick(Outbox&) {}
  virtual LateTicks late_ticks() const { return LateTicks::kCompute; }
  /// LateTicks::kSkip: this many ticks are never computed. Part of the record from which outputs are computed again.
  virtual void skip_ticks(int64_t) {}
  /// The program is asked to end. Where the node must come to an end by itself before, it returns true, and has
  /// finished() later; a node whose outputs can be computed again instead gives a message that it gets, and that is
  /// published, and then ends its ticks.
  virtual bool begin_end() { return false; }
  virtual std::optional<OutMessage> shutdown_request() const { return std::nullopt; }
  /// Whether the node has finished; a live loop then ends.
  virtual bool finished() const { return false; }
  /// For a node whose outputs can be computed again from a log: the digest of its configuration. Such a node's inputs
  /// are published on NODE_INPUTS. Nothing for other nodes.
  virtual std::optional<int64_t> config_digest() const { return std::nullopt; }
  /// Number of messages sent per input, for a node that sends a fixed number for each input.
  virtual int64_t sent_per_input() const { return 1; }
  /// During recomputation, this many consumed inputs are missing from the log: advances the sequence numbers as if
  /// their outputs had been sent. `channel`: theirs; "" where it is unknown.
  virtual void skip_inputs(int64_t, std::string_view) {}
  /// During recomputation, an input is missing from the log, but the outputs that the node sent for it are there:
  /// restores the node's state from these outputs. Returns false, and changes nothing, when they are not sufficient.
  [[nodiscard]] virtual bool restore_from_outputs(const std::vector<std::span<const uint8_t>>&) { return false; }
  /// A short state description for NODE_STATUS.
  virtual std::string state() const = 0;

  /// Identifies this run of the node, in its messages: random live, kVirtualRun in virtual time.
  void set_run(int64_t run) { run_ = run; }
  int64_t run() const { return run_; }
  static constexpr int64_t kVirtualRun = 1;

  const NodeCounters& counters() const { return counters_; }
  /// Empties `sent`, whose memory later messages get.
  void reuse(Outbox& sent) {
    for (OutMessage& message : sent) {
      if (spare_.size() < kMostSpare) spare_.push_back(std::move(message.bytes));
    }
    sent.clear();
  }

  void count_late(int64_t ticks = 1) { counters_.late += ticks; }
  void count_lateness(int64_t us) { ++counters_.lateness[bin_of_lateness(us)]; }

 protected:
  /// Encodes and queues a message.
  template <class Message>
  void send(Outbox& out, std::string_view channel, const Message& message) {
    std::vector<uint8_t> bytes;
    if (!spare_.empty()) {
      bytes = std::move(spare_.back());
      spare_.pop_back();
    }
    if (!encode_into(message, bytes)) return;
    out.push_back({channel, std::move(bytes)});
    ++counters_.sent;
  }

  /// Like `send`, for a message that ends in a field `check`.
  template <class Message>
  void send_with_checksum(Outbox& out, std::string_view channel, const Message& message) {
    const size_t before = out.size();
    send(out, channel, message);
    if (out.size() > before) set_checksum(out.back().bytes);
  }

  /// Decodes a message and counts it as received or refused.
  template <class Message>
  [[nodiscard]] std::optional<Message> decode_and_count(std::span<const uint8_t> bytes) {
    auto message = decode<Message>(bytes);
    ++(message ? counters_.received : counters_.refused);
    return message;
  }
  /// Likewise, into a message whose memory is used again. Returns whether it could be decoded.
  template <class Message>
  [[nodiscard]] bool decode_and_count(std::span<const uint8_t> bytes, Message& message) {
    const bool decoded = decode_into(bytes, message);
    ++(decoded ? counters_.received : counters_.refused);
    return decoded;
  }

  /// For a message on a channel that receive() forgot although inputs() names it.
  std::logic_error unknown_input(std::string_view channel) const {
    return std::logic_error(name() + " does not handle its input " + std::string(channel));
  }

  NodeCounters counters_;

 private:
  static constexpr size_t kMostSpare = 8;
  int64_t run_ = kVirtualRun;
  std::vector<std::vector<uint8_t>> spare_;
};

/// Whether a time is plausible: from 0 to some 36 000 years after it, so that differences of two such times never
/// overflow.
constexpr bool plausible_utime(int64_t utime) {
  return utime >= 0 && utime < (int64_t{1} << 60);
}

/// Counts one publisher's lost messages by their sequence numbers. A number counts as lost once its publisher has come
/// 64 numbers further without it: a message that was only reordered, or came twice, is not lost.
class SequenceGapCounter {
 public:
  /// A message has arrived. Returns how many numbers are known to be lost since the last call. Another `run` is another
  /// publisher; a sequence that goes back is one that was restarted. Neither is a loss.
  int64_t newly_lost(int64_t sequence, int64_t run = 0) {
    if (sequence < 0) return 0;
    if (!newest_ || run != run_) return restart(sequence, run);
    const int64_t step = sequence - *newest_;
    if (step > -kWindow && step <= 0) {
      arrived_ |= uint64_t{1} << -step;
      return 0;
    }
    if (step > 0 && step <= kSudden) return advance(step);
    // Far away: a long gap or a restart, if the next message continues from there; otherwise a damaged number.
    const int64_t begin = std::exchange(unsure_, sequence);
    if (begin < 0) return 0;
    const int64_t further = sequence - begin;
    if (further <= 0 || further > kSudden) return 0;
    const int64_t gap = begin - *newest_;
    const int64_t lost = gap > 0 && gap <= kLargestLoss ? advance(gap) : restart(begin, run);
    return lost + advance(further);
  }

 private:
  static constexpr int64_t kWindow = 64;
  static constexpr int64_t kSudden = 1000;                   // a larger step must be confirmed by the next message
  static constexpr int64_t kLargestLoss = int64_t{1} << 32;  // 49 days at 1 kHz

  int64_t restart(int64_t sequence, int64_t run) {
    newest_ = sequence;
    run_ = run;
    arrived_ = ~uint64_t{0};  // earlier messages are not counted as lost
    unsure_ = -1;
    return 0;
  }
  int64_t advance(int64_t step) {
    const bool far = step >= kWindow;
    const uint64_t leaving = far ? arrived_ : arrived_ >> (kWindow - step);
    const int64_t lost = std::min(step, kWindow) - std::popcount(leaving) + std::max<int64_t>(step - kWindow, 0);
    arrived_ = (far ? 0 : arrived_ << step) | 1;
    *newest_ += step;
    unsure_ = -1;
    return lost;
  }

  std::optional<int64_t> newest_;
  int64_t unsure_ = -1;  // a number far from the newest that has just come; -1 for none
  int64_t run_ = 0;
  uint64_t arrived_ = 0;  // bit k: whether newest_ - k has arrived
};

}  // namespace multireach
