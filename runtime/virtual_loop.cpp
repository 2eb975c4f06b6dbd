#include "runtime/virtual_loop.hpp"

#include <algorithm>

#include "runtime/channels.hpp"

namespace multireach {

void VirtualLoop::add(Node& node, int64_t first_tick_us) {
  // No message is lost in this loop, so NODE_INPUTS repeats no inputs.
  auto member =
      std::make_unique<Member>(Member{&node, node.inputs(), MessageClock(),
                                      InputJournal(node.name(), 0, node.run(), node.config_digest().value_or(0), 0)});
  if (const auto tick = node.next_tick()) member->clock.anchor(*tick, first_tick_us);
  members_.push_back(std::move(member));
}

std::optional<int64_t> VirtualLoop::due(const Member& member) const {
  const auto tick = member.node->next_tick();
  if (!tick) return std::nullopt;
  const int64_t at = member.clock.monotonic_at(*tick);
  return now_us_ ? std::max(at, *now_us_) : at;
}

void VirtualLoop::advance(int64_t now_us) {
  Outbox outbox;
  while (true) {
    Member* next = nullptr;
    int64_t at = now_us;
    for (const auto& member : members_) {
      const auto when = due(*member);
      if (when && *when < at) {
        next = member.get();
        at = *when;
      }
    }
    if (!next) break;
    now_us_ = at;
    next->node->tick(outbox);
    next->journal.ticked();
    observer_.ticked(*next->node);
    send(*next, outbox);
  }
  now_us_ = now_us_ ? std::max(*now_us_, now_us) : now_us;
}

void VirtualLoop::deliver(int64_t now_us, std::string_view channel, std::span<const uint8_t> bytes) {
  advance(now_us);
  dispatch(channel, bytes);
}

void VirtualLoop::dispatch(std::string_view channel, std::span<const uint8_t> bytes) {
  Outbox outbox;
  for (const auto& member : members_) {
    if (std::ranges::find(member->inputs, channel) == member->inputs.end()) continue;
    const Receipt receipt = member->node->receive(channel, bytes, outbox);
    if (receipt.utime && receipt.restarts_ticks) {
      member->clock.anchor(*receipt.utime, *now_us_);
    } else if (receipt.utime) {
      member->clock.observe(*receipt.utime, *now_us_, member->node->late_ticks() == LateTicks::kSkip);
    }
    if (const auto input = member->journal.record(receipt, channel, bytes)) observer_.consumed(*member->node, *input);
    send(*member, outbox);
  }
}

void VirtualLoop::send(Member& sender, Outbox& outbox) {
  if (outbox.empty()) return;
  Outbox messages;
  messages.swap(outbox);
  std::vector<uint8_t> inputs;
  if (sender.journal.next_message(inputs) && sender.node->config_digest())
    observer_.sent(*now_us_, channel::kNodeInputs, inputs);
  for (const OutMessage& message : messages) {
    observer_.sent(*now_us_, message.channel, message.bytes);
    dispatch(message.channel, message.bytes);
  }
  sender.node->reuse(messages);
  if (outbox.empty()) outbox.swap(messages);  // keeps the allocated memory
}

}  // namespace multireach
