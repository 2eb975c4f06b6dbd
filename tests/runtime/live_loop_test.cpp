#include "runtime/live_loop.hpp"

#include <gtest/gtest.h>

#include "runtime/channels.hpp"
#include "runtime/message_clock.hpp"

namespace multireach {
namespace {

/// Ticks take longer than their period, and each sends three messages to the node itself.
class SlowNode : public Node {
 public:
  std::string name() const override { return "slow"; }
  std::vector<std::string_view> inputs() const override { return {channel::kTarget}; }
  std::string state() const override { return ""; }
  std::optional<int64_t> next_tick() const override { return next_us_; }
  int64_t tick_period_us() const override { return kPeriod; }
  bool finished() const override { return ticks_ == kTicks; }
  Receipt receive(std::string_view, std::span<const uint8_t>, Outbox&) override {
    ++received;
    return {};
  }
  void tick(Outbox& out) override {
    most_waiting = std::max(most_waiting, kMessages * ticks_ - received);
    const int64_t end = monotonic_us() + kPeriod * 6 / 5;
    while (monotonic_us() < end) {
    }
    for (int k = 0; k < kMessages; ++k) out.push_back({channel::kTarget, {1, 2, 3}});
    next_us_ += kPeriod;
    ++ticks_;
  }

  static constexpr int64_t kPeriod = 10000;
  static constexpr int kTicks = 40, kMessages = 3;
  int received = 0, most_waiting = 0;

 private:
  int64_t next_us_ = 1000000;
  int ticks_ = 0;
};

// LCM keeps 30 and drops the newest, so that all later ticks would be computed from messages of long before.
TEST(LiveLoop, SlowTicksThatAreLateLeaveNoMessagesWaiting) {
  SlowNode node;
  LiveOptions options;
  options.control_url = options.image_url = "memq://";
  EXPECT_EQ(run_live(node, options), 0);
  EXPECT_GT(node.counters().late, 0) << "the node was to be late";
  EXPECT_LE(node.most_waiting, 2 * SlowNode::kMessages);
}

/// Skips ticks that it misses. Once it is stopped for a second and a half, then handles a message of before.
class StoppedNode : public Node {
 public:
  std::string name() const override { return "stopped"; }
  std::vector<std::string_view> inputs() const override { return {channel::kTarget}; }
  std::string state() const override { return ""; }
  std::optional<int64_t> next_tick() const override { return next_us_; }
  int64_t tick_period_us() const override { return kPeriod; }
  LateTicks late_ticks() const override { return LateTicks::kSkip; }
  void skip_ticks(int64_t ticks) override {
    next_us_ += ticks * kPeriod;
    skipped += ticks;
  }
  bool finished() const override { return ticks_ == kTicks; }
  Receipt receive(std::string_view, std::span<const uint8_t>, Outbox&) override {
    const int64_t end = monotonic_us() + kStop;
    while (monotonic_us() < end) {
    }
    return {.effect = Receipt::Effect::kConsumed, .utime = sent_us_};
  }
  void tick(Outbox& out) override {
    if (ticks_ == kTicks / 2) {
      sent_us_ = next_us_;
      out.push_back({channel::kTarget, {1, 2, 3}});
    }
    next_us_ += kPeriod;
    ++ticks_;
  }

  static constexpr int64_t kPeriod = 1000, kStop = 1500000;
  static constexpr int kTicks = 200;
  int64_t skipped = 0;

 private:
  int64_t next_us_ = 1000000, sent_us_ = 0;
  int ticks_ = 0;
};

// Otherwise a bridge would go on at full speed after the gap, as if no time had passed.
TEST(LiveLoop, AMessageThatWaitedWhileTheNodeWasStoppedDoesNotHideTheGap) {
  StoppedNode node;
  LiveOptions options;
  options.control_url = options.image_url = "memq://";
  EXPECT_EQ(run_live(node, options), 0);
  EXPECT_GE(node.skipped, (StoppedNode::kStop - 10 * StoppedNode::kPeriod) / StoppedNode::kPeriod);
}

}  // namespace
}  // namespace multireach
