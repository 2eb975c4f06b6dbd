#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <multireach/replay_done_t.hpp>
#include <multireach/replay_step_t.hpp>
#include <optional>

#include "runtime/input_journal.hpp"
#include "runtime/node.hpp"

namespace multireach {

using NodeFactory = std::function<std::unique_ptr<Node>()>;

/// Runs a node by the steps of a replay player instead of a clock. Messages may arrive before or after the step that
/// lists them, in any order, late or twice. The node consumes them as the step says and therefore sends the same bytes
/// as the player's own copy of the node.
class Lockstep {
 public:
  /// Most ticks per call of `advance`, so that the node still handles messages during a long step.
  static constexpr int kTicksAtOnce = 500;

  explicit Lockstep(NodeFactory make);

  const Node& node() const { return *node_; }
  /// A message on one of the node's inputs.
  void receive(std::string_view channel, std::span<const uint8_t> bytes);
  /// Starts a step. Returns false, and does nothing, when the step is in progress, already done, or older.
  bool begin(const replay_step_t& step);
  /// Computes as much of the step as possible, up to kTicksAtOnce ticks. Appends the node's messages to `out`, each
  /// after the NODE_INPUTS it depends on. Returns whether more can be computed at once.
  bool advance(Outbox& out);
  bool done() const { return step_ && next_input_ == inputs_.size() && journal_.ticks() >= step_->ticks; }
  bool last() const { return step_ && step_->last; }
  int64_t replay() const { return step_ ? step_->replay : -1; }
  replay_done_t report() const;

 private:
  void restart_node();
  void forward_outputs(Outbox& sent, Outbox& out);
  std::optional<std::vector<uint8_t>> extract_message(const ConsumedInput& input);

  NodeFactory make_;
  std::unique_ptr<Node> node_;
  InputJournal journal_;
  std::optional<replay_step_t> step_;
  std::vector<ConsumedInput> inputs_;
  size_t next_input_ = 0;
  struct Waiting {
    int64_t digest;
    std::vector<uint8_t> bytes;
  };
  std::map<std::string, std::deque<Waiting>, std::less<>> waiting_;
  size_t waiting_bytes_ = 0;
  int64_t sent_ = 0, digest_ = 0;
};

/// Chains one more sent message onto the digest `before` of all earlier ones.
int64_t digest_with(int64_t before, std::string_view channel, std::span<const uint8_t> bytes);

}  // namespace multireach
