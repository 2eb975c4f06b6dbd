#include <gtest/gtest.h>

#include "tools/page/bridge_asker.hpp"
#include "tools/robot/bridge_words.hpp"

namespace multireach {
namespace {

constexpr int64_t kBridge = 77, kMillisecond = 1000;

/// A bridge that takes what it is asked for, and answers as docs/safety.md has it.
struct FakeBridge {
  int64_t run = kBridge;
  bool accepts = true;
  std::vector<int8_t> done{};

  bridge_state_t answer(const bridge_request_t& request) {
    bridge_state_t state{};
    state.run = run;
    state.state = bridge_state_t::ARMED;
    state.speed = 1;
    state.request = request.request;
    state.request_accepted =
        request.kind == bridge_request_t::STATUS || (accepts && request.run == run_asked(request.kind, run));
    if (state.request_accepted && request.kind != bridge_request_t::STATUS) done.push_back(request.kind);
    return state;
  }
};

/// Lets time pass, 20 ms a step, until there is an answer.
std::optional<BridgeAnswer> converse(BridgeAsker& asker, FakeBridge& bridge, int64_t& now) {
  for (int i = 0; i < 200; ++i, now += 20 * kMillisecond) {
    if (const auto request = asker.tick(now)) asker.receive(bridge.answer(*request));
    if (auto answer = asker.take_answer()) return answer;
  }
  return std::nullopt;
}

TEST(BridgeAsker, LearnsTheBridgesRunAndAsks) {
  BridgeAsker asker(1000);
  FakeBridge bridge;
  int64_t now = 0;
  EXPECT_FALSE(asker.tick(now));
  asker.ask("pause", bridge_request_t::PAUSE);
  const auto answer = converse(asker, bridge, now);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->word, "pause");
  EXPECT_TRUE(answer->accepted);
  EXPECT_EQ(answer->text, "armed, speed 100 %, path rate 0 %");
  EXPECT_EQ(bridge.done, std::vector<int8_t>{bridge_request_t::PAUSE});
  EXPECT_FALSE(asker.tick(now));
}

TEST(BridgeAsker, RepeatsARequestThatWasLostUnderTheSameNumber) {
  BridgeAsker asker(1000);
  FakeBridge bridge;
  int64_t now = 0;
  asker.ask("enable", bridge_request_t::ENABLE);
  asker.receive(bridge.answer(*asker.tick(now)));
  const auto first = asker.tick(now);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->kind, bridge_request_t::ENABLE);
  EXPECT_EQ(first->run, kBridge);
  EXPECT_FALSE(asker.tick(now + 199 * kMillisecond));
  const auto again = asker.tick(now + 200 * kMillisecond);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->request, first->request);
}

TEST(BridgeAsker, SaysWhenThereIsNoBridge) {
  BridgeAsker asker(1000);
  asker.ask("enable", bridge_request_t::ENABLE);
  std::optional<BridgeAnswer> answer;
  for (int64_t now = 0; now <= 2100 * kMillisecond; now += 20 * kMillisecond) {
    if (const auto request = asker.tick(now)) {
      EXPECT_EQ(request->kind, bridge_request_t::STATUS);
    }
    if (auto given = asker.take_answer()) answer = given;
  }
  ASSERT_TRUE(answer);
  EXPECT_FALSE(answer->accepted);
  EXPECT_EQ(answer->text, "no answer; is the bridge running?");
}

TEST(BridgeAsker, PassesARefusalOn) {
  BridgeAsker asker(1000);
  FakeBridge bridge{.accepts = false};
  int64_t now = 0;
  asker.ask("reset", bridge_request_t::RESET);
  const auto answer = converse(asker, bridge, now);
  ASSERT_TRUE(answer);
  EXPECT_FALSE(answer->accepted);
  EXPECT_NE(answer->text.find("there is no fault"), std::string::npos) << answer->text;
}

TEST(BridgeAsker, AsksABridgeAgainThatWasRestarted) {
  BridgeAsker asker(1000);
  FakeBridge bridge;
  int64_t now = 0;
  asker.ask("status", bridge_request_t::STATUS);
  ASSERT_TRUE(converse(asker, bridge, now));
  bridge.run = 88;
  asker.ask("pause", bridge_request_t::PAUSE);
  const auto answer = converse(asker, bridge, now);
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->accepted) << answer->text;
  EXPECT_EQ(bridge.done, std::vector<int8_t>{bridge_request_t::PAUSE});
}

TEST(BridgeAsker, NothingThatWasAskedBeforeAStopFollowsIt) {
  BridgeAsker asker(1000);
  FakeBridge bridge;
  int64_t now = 0;
  asker.ask("enable", bridge_request_t::ENABLE);
  asker.ask("resume", bridge_request_t::RESUME);
  asker.tick(now);
  asker.ask("stop", bridge_request_t::DISABLE);
  const auto answer = converse(asker, bridge, now);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->word, "stop");
  EXPECT_TRUE(answer->accepted);
  EXPECT_FALSE(converse(asker, bridge, now));
  EXPECT_EQ(bridge.done, std::vector<int8_t>{bridge_request_t::DISABLE});
}

TEST(BridgeAsker, WaitsForNoMoreThanAFew) {
  BridgeAsker asker(1000);
  for (int i = 0; i < 17; ++i) asker.ask("pause", bridge_request_t::PAUSE);
  const auto answer = asker.take_answer();
  ASSERT_TRUE(answer);
  EXPECT_FALSE(answer->accepted);
  EXPECT_FALSE(asker.take_answer());
}

}  // namespace
}  // namespace multireach
