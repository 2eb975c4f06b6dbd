#include "runtime/lockstep.hpp"

#include <algorithm>

#include "runtime/channels.hpp"

namespace multireach {
namespace {

constexpr size_t kMaxWaiting = 5000;            // messages, per channel
constexpr size_t kMaxBytesWaiting = 256 << 20;  // bytes, all channels together
constexpr int64_t kRestartSteps = 2;            // steps 0 and 1 restart; at step 1 all nodes are in lockstep

InputJournal journal_of(const Node& node, int64_t replay) {
  return {node.name(), replay, node.run(), node.config_digest().value_or(0), 0};
}

}  // namespace

int64_t digest_with(int64_t before, std::string_view channel, std::span<const uint8_t> bytes) {
  return digest_of({before, digest_of(channel), digest_of(bytes)});
}

Lockstep::Lockstep(NodeFactory make) : make_(std::move(make)), node_(make_()), journal_(journal_of(*node_, 0)) {}

void Lockstep::restart_node() {
  node_ = make_();
  journal_ = journal_of(*node_, step_->replay);
  waiting_.clear();
  waiting_bytes_ = 0;
  sent_ = digest_ = 0;
}

void Lockstep::receive(std::string_view channel, std::span<const uint8_t> bytes) {
  std::deque<Waiting>& waiting = waiting_[std::string(channel)];
  waiting.push_back({digest_of(bytes), {bytes.begin(), bytes.end()}});
  waiting_bytes_ += bytes.size();
  while (!waiting.empty() && (waiting.size() > kMaxWaiting || waiting_bytes_ > kMaxBytesWaiting)) {
    waiting_bytes_ -= waiting.front().bytes.size();
    waiting.pop_front();
  }
}

bool Lockstep::begin(const replay_step_t& step) {
  const bool same_replay = step_ && step_->replay == step.replay;
  if (same_replay && step.step <= step_->step) return false;
  step_ = step;
  node_inputs_t named{};
  named.ticks = step.before_tick;
  named.channel_name = step.channel_name;
  named.channel = step.channel;
  named.sequence.assign(step.digest.size(), -1);
  named.digest = step.digest;
  inputs_ = inputs_in(named).value_or(std::vector<ConsumedInput>());
  next_input_ = 0;
  if (!same_replay || step.step < kRestartSteps) restart_node();
  return true;
}

std::optional<std::vector<uint8_t>> Lockstep::extract_message(const ConsumedInput& input) {
  std::deque<Waiting>& waiting = waiting_[std::string(input.channel)];
  const auto found = std::ranges::find(waiting, input.digest, &Waiting::digest);
  if (found == waiting.end()) return std::nullopt;
  std::vector<uint8_t> bytes = std::move(found->bytes);
  waiting_bytes_ -= bytes.size();
  waiting.erase(found);
  return bytes;
}

void Lockstep::forward_outputs(Outbox& sent, Outbox& out) {
  if (sent.empty()) return;
  std::vector<uint8_t> inputs;
  if (node_->config_digest() && journal_.next_message(inputs)) out.push_back({channel::kNodeInputs, std::move(inputs)});
  for (OutMessage& message : sent) {
    ++sent_;
    digest_ = digest_with(digest_, message.channel, message.bytes);
    out.push_back(std::move(message));
  }
  sent.clear();
}

bool Lockstep::advance(Outbox& out) {
  if (!step_) return false;
  Outbox sent;
  int turn = 0;
  const auto tick_until = [&](int64_t ticks) {
    for (; journal_.ticks() < ticks && node_->next_tick(); ++turn) {
      if (turn == kTicksAtOnce) return false;
      node_->tick(sent);
      journal_.ticked();
      forward_outputs(sent, out);
    }
    return true;
  };
  for (; next_input_ < inputs_.size(); ++next_input_) {
    const ConsumedInput& input = inputs_[next_input_];
    if (!tick_until(input.ticks)) return true;
    const auto bytes = extract_message(input);
    if (!bytes) return false;
    const Receipt receipt = node_->receive(input.channel, *bytes, sent);
    journal_.record(receipt, input.channel, *bytes);
    forward_outputs(sent, out);
  }
  return !tick_until(step_->ticks);
}

replay_done_t Lockstep::report() const {
  replay_done_t report{};
  report.node = node_->name();
  if (!step_) return report;
  report.replay = step_->replay;
  report.step = step_->step;
  report.done = done();
  report.sent = sent_;
  report.digest = digest_;
  std::map<int64_t, int64_t> needed;
  for (size_t i = next_input_; i < inputs_.size(); ++i) ++needed[inputs_[i].digest];
  for (const auto& [channel, waiting] : waiting_) {
    for (const Waiting& message : waiting) {
      if (const auto need = needed.find(message.digest); need != needed.end()) --need->second;
    }
  }
  for (const auto& [digest, count] : needed) {
    if (count > 0) report.missing.push_back(digest);
  }
  report.num_missing = static_cast<int32_t>(report.missing.size());
  return report;
}

}  // namespace multireach
