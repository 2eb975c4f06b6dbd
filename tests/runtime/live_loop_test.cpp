#include "runtime/live_loop.hpp"

#include <gtest/gtest.h>

#include "runtime/channels.hpp"
#include "runtime/message_clock.hpp"

namespace multireach {
namespace {

void be_busy(int64_t us) {
  const int64_t end = monotonic_us() + us;
  while (monotonic_us() < end) {
  }
}

/// Ticks a number of times; hears what it sends.
class TickingNode : public Node {
 public:
  TickingNode(int64_t period_us, int ticks) : period_us_(period_us), last_(ticks) {}
  std::string name() const override { return "node"; }
  std::vector<std::string_view> inputs() const override { return {channel::kTarget}; }
  std::string state() const override { return ""; }
  std::optional<int64_t> next_tick() const override { return next_us_; }
  int64_t tick_period_us() const override { return period_us_; }
  bool finished() const override { return ticks_ == last_; }
  Receipt receive(std::string_view, std::span<const uint8_t>, Outbox&) override { return {}; }
  void tick(Outbox&) override {
    next_us_ += period_us_;
    ++ticks_;
  }
  /// Returns its counters.
  NodeCounters run() {
    LiveOptions options;
    options.control_url = options.image_url = "memq://";
    EXPECT_EQ(run_live(*this, options), 0);
    return counters();
  }

 protected:
  int64_t period_us_, next_us_ = 1000000;
  int last_, ticks_ = 0;
};

/// Ticks take longer than their period, and each sends three messages to the node itself.
class SlowNode : public TickingNode {
 public:
  SlowNode() : TickingNode(10000, 40) {}
  Receipt receive(std::string_view, std::span<const uint8_t>, Outbox&) override {
    ++received_;
    return {};
  }
  void tick(Outbox& out) override {
    most_waiting = std::max(most_waiting, kMessages * ticks_ - received_);
    be_busy(period_us_ * 6 / 5);
    for (int k = 0; k < kMessages; ++k) out.push_back({channel::kTarget, {1, 2, 3}});
    TickingNode::tick(out);
  }
  static constexpr int kMessages = 3;
  int most_waiting = 0;

 private:
  int received_ = 0;
};

// LCM keeps 30 and drops the newest, so that all later ticks would be computed from messages of long before.
TEST(LiveLoop, SlowTicksThatAreLateLeaveNoMessagesWaiting) {
  SlowNode node;
  EXPECT_GT(node.run().late, 0) << "the node was to be late";
  EXPECT_LE(node.most_waiting, 2 * SlowNode::kMessages);
}

/// Skips ticks that it misses. Once it is stopped for a second and a half, then handles a message of before.
class StoppedNode : public TickingNode {
 public:
  StoppedNode() : TickingNode(1000, 200) {}
  LateTicks late_ticks() const override { return LateTicks::kSkip; }
  void skip_ticks(int64_t ticks) override {
    next_us_ += ticks * period_us_;
    skipped += ticks;
  }
  Receipt receive(std::string_view, std::span<const uint8_t>, Outbox&) override {
    be_busy(1500000);
    return {.effect = Receipt::Effect::kConsumed, .utime = sent_us_};
  }
  void tick(Outbox& out) override {
    if (ticks_ == last_ / 2) {
      sent_us_ = next_us_;
      out.push_back({channel::kTarget, {1, 2, 3}});
    }
    TickingNode::tick(out);
  }
  int64_t skipped = 0;

 private:
  int64_t sent_us_ = 0;
};

// Otherwise a bridge would go on at full speed after the gap, as if no time had passed.
TEST(LiveLoop, AMessageThatWaitedWhileTheNodeWasStoppedDoesNotHideTheGap) {
  StoppedNode node;
  node.run();
  EXPECT_GE(node.skipped, 1490) << "of 1500 periods";
}

/// Sends itself a message, then is stopped before it can hear it.
class LateHearer : public StoppedNode {
 public:
  Receipt receive(std::string_view, std::span<const uint8_t>, Outbox&) override {
    skipped_before_message = skipped;
    return {};
  }
  void tick(Outbox& out) override {
    if (ticks_ == last_ / 2) {
      out.push_back({channel::kTarget, {1, 2, 3}});
      be_busy(30000);
    }
    TickingNode::tick(out);
  }
  int64_t skipped_before_message = -1;
};

// What a driver hears after a stop must not be taken for what it heard in time.
TEST(LiveLoop, TheTimeThatHasPassedComesBeforeAMessageThatWaited) {
  LateHearer node;
  node.run();
  EXPECT_GE(node.skipped_before_message, 25) << "of 30 periods";
}

/// Ends some ticks after it was asked to.
class EndingNode : public TickingNode {
 public:
  EndingNode() : TickingNode(1000, 1 << 30) {}
  std::optional<OutMessage> shutdown_request() const override { return OutMessage{channel::kTarget, {1, 2, 3}}; }
  Receipt receive(std::string_view, std::span<const uint8_t>, Outbox&) override {
    ++requests;
    last_ = ticks_ + 50;
    return {};
  }
  int requests = 0;
};

// LCM gives it back as well, where it has a network.
TEST(LiveLoop, ANodeThatMustEndByItselfIsAskedOnce) {
  EndingNode node;
  LiveOptions options;
  options.control_url = options.image_url = "memq://";
  options.seconds = 0.1;
  EXPECT_EQ(run_live(node, options), 0);
  EXPECT_TRUE(node.finished());
  EXPECT_EQ(node.requests, 1);
}

/// As a driver: ends some ticks after it was told to, without a message. It is late by then, so that several ticks are
/// due at once.
class DeceleratingNode : public TickingNode {
 public:
  DeceleratingNode() : TickingNode(1000, 1 << 30) {}
  bool begin_end() override {
    ++requests;
    last_ = ticks_ + 10;
    be_busy(20000);
    return true;
  }
  int requests = 0;
};

TEST(LiveLoop, ANodeThatMustDecelerateIsToldOnceAndAwaited) {
  DeceleratingNode node;
  LiveOptions options;
  options.control_url = options.image_url = "memq://";
  options.seconds = 0.1;
  EXPECT_EQ(run_live(node, options), 0);
  EXPECT_TRUE(node.finished()) << "and no tick after its last one, though more were due";
  EXPECT_EQ(node.requests, 1);
}

/// Each tick sends it three images; it fails on the first that it handles.
class NewestNode : public TickingNode {
 public:
  NewestNode() : TickingNode(10000, 20) {}
  bool takes_newest(std::string_view) const override { return true; }
  void leave_out(std::string_view channel, std::span<const uint8_t> bytes) override {
    Node::leave_out(channel, bytes);
    arrived.push_back(bytes[0]);
    left_out.push_back(bytes[0]);
    EXPECT_LT(bytes[0] + 1, sent) << "no newer one was waiting";
  }
  Receipt receive(std::string_view, std::span<const uint8_t> bytes, Outbox&) override {
    arrived.push_back(bytes[0]);
    handled.push_back(bytes[0]);
    if (handled.size() == 1) throw std::runtime_error("a test");
    return {};
  }
  void tick(Outbox& out) override {
    for (int k = 0; k < kImages; ++k) out.push_back({channel::kTarget, {sent++}});
    TickingNode::tick(out);
  }
  static constexpr int kImages = 3;
  uint8_t sent = 0;
  std::vector<int> handled, left_out, arrived;
};

// On a busy machine ticks are late, too, and the images of several of them wait.
TEST(LiveLoop, OfWaitingImagesTheNewestIsHandled) {
  NewestNode node;
  const NodeCounters counters = node.run();
  ASSERT_FALSE(node.handled.empty());
  for (const int image : node.handled) EXPECT_EQ(image % NewestNode::kImages, NewestNode::kImages - 1) << image;
  for (size_t k = 0; k < node.arrived.size(); ++k) EXPECT_EQ(node.arrived[k], k) << "all of them, in order";
  EXPECT_GE(node.arrived.size(), node.sent - NewestNode::kImages) << "only those of the last tick may still wait";
  EXPECT_GE(counters.late, std::ssize(node.left_out));
}

}  // namespace
}  // namespace multireach
