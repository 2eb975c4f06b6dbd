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
  int64_t late = 0;      ///< ticks computed more than one period after their nominal time
  int64_t limited = 0;   ///< outputs changed by a limit
  int64_t sent = 0;      ///< messages published
};

/// How a received message affected the node.
struct Receipt {
  enum class Effect {
    kNone,      ///< the node's outputs do not depend on it
    kTaken,     ///< the node's state depends on it
    kReplaces,  ///< as kTaken, and an earlier message of this channel since the last tick no longer has any effect
  };
  Effect effect = Effect::kNone;
  std::optional<int64_t> utime{};  ///< time in the message that the ticks are aligned to, if any
  int64_t sequence = -1;           ///< the message's sequence number; -1 if it has none
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
  /// The nominal time of the next tick, in message time; nothing while the node does not tick.
  virtual std::optional<int64_t> next_tick() const { return std::nullopt; }
  virtual int64_t tick_period_us() const { return 0; }
  virtual void tick(Outbox&) {}
  /// Whether the node has finished; a live loop then ends.
  virtual bool finished() const { return false; }
  /// For a node whose outputs can be computed again from a log: the digest of its configuration. Such a node's inputs
  /// are published on NODE_INPUTS. Nothing for other nodes.
  virtual std::optional<int64_t> replayable() const { return std::nullopt; }
  /// Number of messages sent per input, for a node that sends a fixed number for each input.
  virtual int64_t sent_per_input() const { return 1; }
  /// During recomputation, this many consumed inputs are missing from the log: advances the sequence numbers as if
  /// their outputs had been sent.
  virtual void skip(int64_t) {}
  /// During recomputation, an input is missing from the log, but the outputs that the node sent for it are there:
  /// restores the node's state from these outputs. Returns false, and changes nothing, when they are not sufficient.
  virtual bool deserialize(const std::vector<std::span<const uint8_t>>&) { return false; }
  /// A short state description for NODE_STATUS.
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

  /// Like `send`, for a message that ends in a field `check`.
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

/// Whether a time is plausible: from 0 to some 36 000 years after it, so that differences of two such times never
/// overflow.
constexpr bool plausible_utime(int64_t utime) {
  return utime >= 0 && utime < (int64_t{1} << 60);
}

/// Detects lost messages from one publisher's sequence numbers.
class SequenceWatch {
 public:
  /// Number of messages missing just before this one. A sequence that restarts at a smaller number (the publisher was
  /// restarted, a log is played again) is not a loss.
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
