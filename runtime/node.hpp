#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/digest.hpp"
#include "runtime/message.hpp"

namespace multireach {

/// A message that a node wants published.
struct OutMessage {
  std::string_view channel;  // one of runtime/channels.hpp
  std::vector<uint8_t> bytes;
};
using Outbox = std::vector<OutMessage>;

/// What NODE_STATUS reports; all count from the node's start.
struct NodeCounters {
  int64_t received = 0;  ///< messages taken in
  int64_t dropped = 0;   ///< messages that never came, told by gaps in the sequence numbers
  int64_t refused = 0;   ///< messages that could not be decoded or were not valid
  int64_t late = 0;      ///< ticks computed later than one period after their nominal time
  int64_t limited = 0;   ///< outputs that a guard had to alter
  int64_t sent = 0;      ///< messages published
};

/// What a message was to the node that got it.
struct Receipt {
  enum class Effect {
    kNone,      ///< what the node sends would have been the same without it
    kTaken,     ///< the node's state depends on it
    kReplaces,  ///< the same, and nothing depends any more on the last one of this channel, if it came since the last
                ///< tick
  };
  Effect effect = Effect::kNone;
  std::optional<int64_t> utime{};  ///< the time that the node's grid of ticks follows, when the message carries it
  int64_t sequence = -1;           ///< the message's own; -1 where it has none
};

/// A stage bound to its messages: events with their times in, messages out. Knows no LCM and no clock, so the same
/// object runs live, in a replay and in a test.
class Node {
 public:
  virtual ~Node() = default;

  virtual std::string name() const = 0;
  virtual std::vector<std::string_view> inputs() const = 0;
  /// Takes a message of one of the inputs. What the node sends is a function of the messages that had an effect, their
  /// order, and which of them came before which of its ticks; so a record of those is enough to compute it again.
  virtual Receipt receive(std::string_view channel, std::span<const uint8_t> bytes, Outbox& out) = 0;
  /// The nominal time of the next tick, in the time of the messages; nothing while the node does not tick.
  virtual std::optional<int64_t> next_tick() const { return std::nullopt; }
  virtual int64_t tick_period_us() const { return 0; }
  virtual void tick(Outbox&) {}
  /// Whether there is nothing left to do; a live loop then ends.
  virtual bool finished() const { return false; }
  /// Digest of the configuration of a node whose messages shall be computed again from a log: it says on NODE_INPUTS
  /// what it took in. Nothing for others.
  virtual std::optional<int64_t> replayable() const { return std::nullopt; }
  /// How many messages it sends for one that it takes in, of a node whose messages are counted by those it takes in.
  virtual int64_t sent_per_input() const { return 1; }
  /// So many messages that it had taken in cannot be had again: counts what it sent for them.
  virtual void skip(int64_t) {}
  /// A message that it had taken in cannot be had again, but this is what it sent for it: remembers what it would then.
  /// Returns false, and changes nothing, where that is not enough.
  virtual bool adopt(const std::vector<std::span<const uint8_t>>&) { return false; }
  /// A few words for NODE_STATUS.
  virtual std::string state() const = 0;

  const NodeCounters& counters() const { return counters_; }
  void count_late() { ++counters_.late; }

 protected:
  /// Encodes and queues a message.
  template <class Message>
  void send(Outbox& out, std::string_view channel, const Message& message) {
    auto bytes = encode(message);
    if (!bytes) return;
    out.push_back({channel, std::move(*bytes)});
    ++counters_.sent;
  }

  /// The same for a message that ends in a field `check`.
  template <class Message>
  void send_sealed(Outbox& out, std::string_view channel, const Message& message) {
    const size_t before = out.size();
    send(out, channel, message);
    if (out.size() > before) seal(out.back().bytes);
  }

  /// Decodes a message and counts it as received or refused.
  template <class Message>
  std::optional<Message> take(std::span<const uint8_t> bytes) {
    auto message = decode<Message>(bytes);
    ++(message ? counters_.received : counters_.refused);
    return message;
  }

  NodeCounters counters_;
};

/// Whether a time can be one: from 0 to some 36 000 years after it, so that differences of two such times never
/// overflow.
constexpr bool plausible_utime(int64_t utime) {
  return utime >= 0 && utime < (int64_t{1} << 60);
}

/// Watches one publisher's sequence numbers.
class SequenceWatch {
 public:
  /// How many messages are missing just before this one. A sequence that starts again at a smaller number (the
  /// publisher was restarted, a log is played again) is no loss.
  int64_t missing_before(int64_t sequence) {
    if (sequence < 0) return 0;
    const int64_t missing = newest_ && sequence > *newest_ ? sequence - *newest_ - 1 : 0;
    newest_ = sequence;
    return missing;
  }

 private:
  std::optional<int64_t> newest_;
};

}  // namespace multireach
