#pragma once

#include <deque>
#include <multireach/node_inputs_t.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/node.hpp"

namespace multireach {

/// Stands for a channel in ConsumedInput: the clock, which made the node skip `sequence` ticks.
inline constexpr std::string_view kClockInput = "CLOCK";

/// A message that a node has consumed.
struct ConsumedInput {
  int64_t ticks = 0;  ///< number of ticks that the node had computed before it
  std::string channel;
  int64_t sequence = -1;
  int64_t digest = 0;

  bool operator==(const ConsumedInput&) const = default;
};

/// Records the messages that a node consumes and publishes this record on NODE_INPUTS. From the record, the node's
/// outputs can be computed again.
class InputJournal {
 public:
  /// `run` identifies this record; `sender_run` is in the node's messages. `repeated`: how many inputs that were
  /// already published each message repeats, in case a recorder loses one.
  InputJournal(std::string node, int64_t run, int64_t sender_run, int64_t config_digest, size_t repeated);

  /// Call when the node has received a message. Returns its entry in the record, or nothing when the message had no
  /// effect.
  std::optional<ConsumedInput> record(const Receipt& receipt, std::string_view channel, std::span<const uint8_t> bytes);
  /// Call when the node has skipped ticks.
  void record_skip(int64_t ticks);
  void ticked() { ++ticks_; }
  int64_t ticks() const { return ticks_; }
  /// Encodes the next NODE_INPUTS message into `bytes`, whose memory is used again. Returns false when there is no new
  /// input since the last one.
  [[nodiscard]] bool next_message(std::vector<uint8_t>& bytes);

 private:
  std::string node_;
  int64_t run_, sender_run_, config_digest_;
  size_t repeated_;
  std::deque<ConsumedInput> newest_;
  node_inputs_t message_{};
  int64_t recorded_ = 0, published_ = 0;
  int64_t ticks_ = 0;
};

/// Appends the index of a channel's name in `names`, which gets the name where it is new: NODE_INPUTS and REPLAY_STEP
/// name each channel once.
void append_channel(const std::string& channel, std::vector<std::string>& names, std::vector<int8_t>& indices);
/// The inputs that a message names; nothing when an index of a channel is out of range.
[[nodiscard]] std::optional<std::vector<ConsumedInput>> inputs_in(const node_inputs_t& message);

}  // namespace multireach
