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

using NodeMaker = std::function<std::unique_ptr<Node>()>;

/// A node that follows a player's steps and no clock. Messages may come before the step that names them or after it, in
/// any order, twice or late; the node takes them as the step says, and so sends the same bytes as in the player.
class Lockstep {
 public:
  /// Enough for one turn: a node that computes a long step still listens.
  static constexpr int kTicksAtOnce = 500;

  explicit Lockstep(NodeMaker make);

  const Node& node() const { return *node_; }
  /// A message on one of the node's inputs.
  void receive(std::string_view channel, std::span<const uint8_t> bytes);
  /// Takes a step. Returns false, and does nothing, for one that is under way, done or older.
  bool begin(const replay_step_t& step);
  /// Does what can be done, kTicksAtOnce at most. What the node sends is appended to `out`, with what it says about its
  /// inputs. Returns whether there is more that can be done at once.
  bool advance(Outbox& out);
  bool done() const { return step_ && next_input_ == inputs_.size() && journal_.ticks() >= step_->ticks; }
  bool last() const { return step_ && step_->last; }
  int64_t replay() const { return step_ ? step_->replay : -1; }
  replay_done_t report() const;

 private:
  void start_afresh();
  void hand_on(Outbox& sent, Outbox& out);
  std::optional<std::vector<uint8_t>> taken(const ConsumedInput& input);

  NodeMaker make_;
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

/// The digest of everything sent so far and one more message.
int64_t digest_with(int64_t before, std::string_view channel, std::span<const uint8_t> bytes);

}  // namespace multireach
