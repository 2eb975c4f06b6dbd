#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "runtime/input_journal.hpp"
#include "runtime/message_clock.hpp"
#include "runtime/node.hpp"

namespace multireach {

/// Runs nodes in virtual time, without processes, network or waiting: the same objects that `run_live` runs. Messages
/// arrive when they are sent. Events at the same time are processed in a fixed order: first inputs from outside, then
/// the nodes' ticks in the order in which the nodes were added, each message being delivered at once. So the same
/// inputs give the same outputs on any machine, as fast as it can compute.
class VirtualLoop {
 public:
  struct Observer {
    virtual ~Observer() = default;
    /// A message that a node has sent.
    virtual void sent(int64_t now_us, std::string_view channel, std::span<const uint8_t> bytes) = 0;
    /// The node has consumed a message.
    virtual void consumed(const Node&, const ConsumedInput&) {}
    /// The node has computed a tick.
    virtual void ticked(const Node&) {}
  };

  explicit VirtualLoop(Observer& observer) : observer_(observer) {}

  /// Adds a node. If it ticks from the start, its first tick is at `first_tick_us` of the loop's time.
  void add(Node& node, int64_t first_tick_us);
  /// Computes all ticks before `now_us`, then delivers a message from outside. `now_us` must not decrease.
  void deliver(int64_t now_us, std::string_view channel, std::span<const uint8_t> bytes);
  /// Computes all ticks before `now_us`.
  void advance(int64_t now_us);

 private:
  struct Member {
    Node* node;
    std::vector<std::string_view> inputs;
    MessageClock clock;
    InputJournal journal;
  };

  /// Time of the member's next tick, in the loop's time.
  std::optional<int64_t> due(const Member& member) const;
  void dispatch(std::string_view channel, std::span<const uint8_t> bytes);
  void send(Member& sender, Outbox& outbox);

  Observer& observer_;
  std::vector<std::unique_ptr<Member>> members_;
  std::optional<int64_t> now_us_;
};

}  // namespace multireach
