#include "runtime/virtual_loop.hpp"

#include <algorithm>

#include "runtime/channels.hpp"

namespace multireach {

void VirtualLoop::add(Node& node, int64_t first_tick_us) {
  // No message is lost in this loop, so NODE_INPUTS repeats no inputs.
  auto member = std::make_unique<Member>(
      Member{&node, node.inputs(), MessageClock(), InputJournal(node.name(), 0, node.replayable().value_or(0), 0)});
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
  pass_on(channel, bytes);
}

void VirtualLoop::pass_on(std::string_view channel, std::span<const uint8_t> bytes) {
  Outbox outbox;
  for (const auto& member : members_) {
    if (std::ranges::find(member->inputs, channel) == member->inputs.end()) continue;
    const Receipt receipt = member->node->receive(channel, bytes, outbox);
    if (receipt.utime) member->clock.observe(*receipt.utime, *now_us_);
    if (const auto taken = member->journal.took(receipt, channel, bytes)) observer_.took(*member->node, *taken);
    send(*member, outbox);
  }
}

void VirtualLoop::send(Member& sender, Outbox& outbox) {
  if (outbox.empty()) return;
  Outbox messages;
  messages.swap(outbox);
  const auto news = sender.journal.news();
  if (news && sender.node->replayable()) observer_.sent(*now_us_, channel::kNodeInputs, *news);
  for (const OutMessage& message : messages) {
    observer_.sent(*now_us_, message.channel, message.bytes);
    pass_on(message.channel, message.bytes);
  }
  messages.clear();
  if (outbox.empty()) outbox.swap(messages);  // keeps the allocated memory
}

}  // namespace multireach
