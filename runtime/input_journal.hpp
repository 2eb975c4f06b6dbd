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

/// A message that a node took in.
struct ConsumedInput {
  int64_t ticks = 0;  ///< that the node had computed before
  std::string_view channel;
  int64_t sequence = -1;
  int64_t digest = 0;

  bool operator==(const ConsumedInput&) const = default;
};

/// Keeps what a node takes in, and says it: with that, its outputs can be computed again.
class InputJournal {
 public:
  /// `run` tells the runs of the node apart; `repeated`: how many inputs that were said before are said again.
  InputJournal(std::string node, int64_t run, int64_t config_digest, size_t repeated);

  /// The node has received a message. Returns what it is called where it had an effect.
  std::optional<ConsumedInput> took(const Receipt& receipt, std::string_view channel, std::span<const uint8_t> bytes);
  void ticked() { ++ticks_; }
  int64_t ticks() const { return ticks_; }
  /// The message for NODE_INPUTS, when there is something that was not said before.
  std::optional<std::vector<uint8_t>> news();

 private:
  std::string node_;
  int64_t run_, config_digest_;
  size_t repeated_;
  std::deque<ConsumedInput> newest_;
  int64_t taken_ = 0, said_ = 0;
  int64_t ticks_ = 0;
};

/// The number of a channel in NODE_INPUTS and REPLAY_STEP. Needs an input that a journal has given.
int8_t number_of(const ConsumedInput& input);
/// The inputs that a message names; nothing when it names an unknown channel.
std::optional<std::vector<ConsumedInput>> inputs_in(const node_inputs_t& message);

}  // namespace multireach
