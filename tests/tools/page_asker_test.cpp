#include <gtest/gtest.h>

#include <utility>

#include "tools/robot/bridge_asker.hpp"
#include "tools/robot/bridge_words.hpp"

namespace multireach {
namespace {

constexpr int64_t kBridge = 77, kMillisecond = 1000;

/// A bridge that takes what it is asked for, and answers as docs/safety.md has it.
struct FakeBridge {
  int64_t run = kBridge;
  bool accepts = true;
  int8_t in = bridge_state_t::ARMED;
  double speed = 1;
  const char* cause = "";
  std::vector<int8_t> done{};
  int64_t last = 0;

  bridge_state_t answer(const bridge_request_t& request) {
    bridge_state_t state{};
    state.run = run;
    state.state = in;
    state.speed = speed;
    state.cause = cause;
    state.request = request.request;
    state.request_accepted = request.kind == bridge_request_t::STATUS ||
                             (accepts && request.run == (asks_all(request.kind) ? bridge_request_t::ALL : run));
    const bool repeated = std::exchange(last, request.request) == request.request;  // as the answer may be lost
    if (state.request_accepted && !repeated && request.kind != bridge_request_t::STATUS) done.push_back(request.kind);
    return state;
  }
};

/// Lets time pass, 20 ms a step, until there is an answer. The robot is there.
std::optional<BridgeAnswer> converse(BridgeAsker& asker, FakeBridge& bridge, int64_t& now, bool robot = true) {
  for (int i = 0; i < 200; ++i, now += 20 * kMillisecond) {
    if (const auto request = asker.tick(now)) asker.receive(bridge.answer(*request));
    if (robot) asker.receive_robot_state();
    if (auto answer = asker.take_answer()) return answer;
  }
  return std::nullopt;
}

TEST(BridgeAsker, LearnsTheBridgesRunAndAsks) {
  BridgeAsker asker(1000);
  FakeBridge bridge;
  int64_t now = 0;
  EXPECT_FALSE(asker.tick(now));
  asker.ask("resume", bridge_request_t::RESUME);
  const auto answer = converse(asker, bridge, now);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->word, "resume");
  EXPECT_TRUE(answer->accepted);
  EXPECT_EQ(answer->text(), "armed, speed 100 %, path rate 0 %");
  EXPECT_EQ(bridge.done, std::vector<int8_t>{bridge_request_t::RESUME});
  EXPECT_FALSE(asker.tick(now));
}

TEST(BridgeAsker, StopsAndPausesEveryBridgeAtOnce) {
  for (const int8_t kind : {bridge_request_t::DISABLE, bridge_request_t::PAUSE}) {
    BridgeAsker asker(1000);
    int64_t now = 0;
    asker.ask("resume", bridge_request_t::RESUME);  // in the middle of another question
    (void)asker.tick(now);
    asker.ask("stop", kind);
    const auto request = asker.tick(now += 20 * kMillisecond);
    ASSERT_TRUE(request) << "before any bridge has answered";
    EXPECT_EQ(request->kind, kind);
    EXPECT_EQ(request->run, bridge_request_t::ALL);
    // Two bridges take it; the second one got only the repetition.
    FakeBridge first, second{.run = 88};
    asker.receive(first.answer(*request));
    std::optional<BridgeAnswer> answer;
    for (int i = 0; i < 50 && !answer; ++i) {
      if (const auto again = asker.tick(now += 20 * kMillisecond)) {
        EXPECT_EQ(again->request, request->request);
        asker.receive(first.answer(*again));
        asker.receive(second.answer(*again));
      }
      answer = asker.take_answer();
    }
    ASSERT_TRUE(answer);
    EXPECT_TRUE(answer->accepted);
    EXPECT_EQ(answer->text(), "armed, speed 100 %, path rate 0 %; armed, speed 100 %, path rate 0 %");
    EXPECT_EQ(second.done, std::vector<int8_t>{kind});
  }
}

TEST(BridgeAsker, AsksNothingElseOfTwoBridges) {
  for (const int8_t kind :
       {bridge_request_t::ENABLE, bridge_request_t::RESUME, bridge_request_t::RESET, bridge_request_t::SPEED}) {
    BridgeAsker asker(1000);
    FakeBridge first, second{.run = 88};
    asker.ask("enable", kind, 0.5);
    std::optional<BridgeAnswer> answer;
    for (int64_t now = 0; now < 1000 * kMillisecond && !answer; now += 20 * kMillisecond) {
      if (const auto request = asker.tick(now)) {
        EXPECT_EQ(request->kind, bridge_request_t::STATUS);
        asker.receive(first.answer(*request));
        asker.receive(second.answer(*request));
      }
      answer = asker.take_answer();
    }
    ASSERT_TRUE(answer);
    EXPECT_FALSE(answer->accepted);
    EXPECT_NE(answer->problem.find("2 bridges answer"), std::string::npos) << answer->text();
    EXPECT_TRUE(first.done.empty() && second.done.empty());
  }
}

TEST(BridgeAsker, SaysWhyNothingMovesThoughTheBridgeAgrees) {
  const auto problem = [](int8_t kind, int8_t state, double speed = 1, const char* cause = "") {
    BridgeAsker asker(1000);
    FakeBridge bridge{.in = state, .speed = speed, .cause = cause};
    int64_t now = 0;
    asker.ask("word", kind, 1);
    const auto answer = converse(asker, bridge, now);
    EXPECT_TRUE(answer && answer->accepted == answer->problem.empty());
    return answer ? answer->problem : "";
  };
  EXPECT_NE(problem(bridge_request_t::RESUME, bridge_state_t::IDLE).find("`multireach-robot enable`"),
            std::string::npos);
  EXPECT_NE(problem(bridge_request_t::RESUME, bridge_state_t::FAULT).find("`multireach-robot reset`"),
            std::string::npos);
  EXPECT_NE(problem(bridge_request_t::ENABLE, bridge_state_t::FAULT).find("`multireach-robot reset`"),
            std::string::npos);
  EXPECT_NE(problem(bridge_request_t::RESUME, bridge_state_t::ARMED, 0).find("speed PERCENT"), std::string::npos);
  EXPECT_NE(problem(bridge_request_t::ENABLE, bridge_state_t::ARMED, 1, "paused").find("`multireach-robot resume`"),
            std::string::npos);
  EXPECT_NE(
      problem(bridge_request_t::RESUME, bridge_state_t::STOPPING, 1, "disabled").find("`multireach-robot enable`"),
      std::string::npos);
  EXPECT_EQ(problem(bridge_request_t::RESUME, bridge_state_t::RUNNING), "");
  EXPECT_EQ(problem(bridge_request_t::SPEED, bridge_state_t::IDLE, 0.1), "") << "set before the robot is enabled";
}

TEST(BridgeAsker, SaysThatTheRobotIsMissing) {
  for (const int8_t kind :
       {bridge_request_t::ENABLE, bridge_request_t::RESUME, bridge_request_t::RESET, bridge_request_t::SPEED}) {
    BridgeAsker asker(1000);
    FakeBridge bridge;
    int64_t now = 0;
    asker.ask("reset", kind, 1);
    const auto answer = converse(asker, bridge, now, false);
    ASSERT_TRUE(answer);
    EXPECT_FALSE(answer->accepted);
    EXPECT_NE(answer->problem.find("no ROBOT_STATE arrives"), std::string::npos) << answer->text();
    EXPECT_EQ(bridge.done, std::vector<int8_t>{kind});
  }
}

TEST(BridgeAsker, RepeatsARequestThatWasLostUnderTheSameNumber) {
  BridgeAsker asker(1000);
  FakeBridge bridge;
  int64_t now = 0;
  asker.ask("enable", bridge_request_t::ENABLE);
  asker.receive(bridge.answer(*asker.tick(now)));
  (void)asker.tick(now);
  const auto first = asker.tick(now += BridgeAsker::kOthersAnswer);
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
  EXPECT_NE(answer->text().find("no answer; is multireach-bridge running"), std::string::npos);
}

TEST(BridgeAsker, PassesARefusalOn) {
  BridgeAsker asker(1000);
  FakeBridge bridge{.accepts = false};
  int64_t now = 0;
  asker.ask("reset", bridge_request_t::RESET);
  const auto answer = converse(asker, bridge, now);
  ASSERT_TRUE(answer);
  EXPECT_FALSE(answer->accepted);
  EXPECT_NE(answer->text().find("there is no fault"), std::string::npos) << answer->text();
}

TEST(BridgeAsker, AsksABridgeAgainThatWasRestarted) {
  BridgeAsker asker(1000);
  FakeBridge bridge;
  int64_t now = 0;
  asker.ask("status", bridge_request_t::STATUS);
  ASSERT_TRUE(converse(asker, bridge, now));
  bridge.run = 88;
  asker.ask("resume", bridge_request_t::RESUME);
  const auto answer = converse(asker, bridge, now);
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->accepted) << answer->text();
  EXPECT_EQ(bridge.done, std::vector<int8_t>{bridge_request_t::RESUME});
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
  for (int i = 0; i < 17; ++i) asker.ask("resume", bridge_request_t::RESUME);
  const auto answer = asker.take_answer();
  ASSERT_TRUE(answer);
  EXPECT_FALSE(answer->accepted);
  EXPECT_FALSE(asker.take_answer());
}

}  // namespace
}  // namespace multireach
