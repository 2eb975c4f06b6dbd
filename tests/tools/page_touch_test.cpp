#include <gtest/gtest.h>

#include <multireach/bridge_state_t.hpp>
#include <multireach/obstacles_t.hpp>
#include <multireach/perturbation_t.hpp>
#include <multireach/robot_state_t.hpp>
#include <nlohmann/json.hpp>

#include "runtime/channels.hpp"
#include "tools/page/touch.hpp"

namespace multireach {
namespace {

using json = nlohmann::json;

constexpr int64_t kNow = 5000000;

class PageTouch : public ::testing::Test {
 protected:
  template <class Message>
  std::vector<Message> sent(std::string_view channel) const {
    std::vector<Message> found;
    for (const OutMessage& message : out_) {
      if (message.channel == channel) found.push_back(*decode<Message>(message.bytes));
    }
    return found;
  }
  template <class Message>
  void hear(std::string_view channel, const Message& message, int64_t now_us) {
    touch_.receive(channel, *encode(message), now_us, out_);
  }
  std::optional<Touch::Answer> move(const std::string& client, double x, int64_t now_us) {
    return touch_.handle({{"request", "target"}, {"client", client}, {"position_m", {x, 0, 0}}}, now_us, out_);
  }
  static target_t ball(int64_t utime) {
    target_t target{};
    target.name = "ball";
    target.run = 99;
    target.utime = utime;
    return target;
  }

  Touch touch_{7};
  Outbox out_;
};

TEST_F(PageTouch, TheTargetIsChosenAgainAndAgainAndFollowsTheHandAtALimitedSpeedInTheTimeOfTheImages) {
  ASSERT_TRUE(move("a", 0.1, kNow)->accepted);
  const auto choices = sent<target_choice_t>(channel::kTargetChoice);
  ASSERT_EQ(choices.size(), 1U);
  EXPECT_EQ(choices[0].kind, target_choice_t::NAMED);
  EXPECT_EQ(choices[0].name, "page");
  EXPECT_EQ(choices[0].run, 7);
  EXPECT_FALSE(move("a", 1.1, kNow)) << "no answer to each step of a drag";
  for (int64_t k = 0; k <= 30; ++k) hear(channel::kTarget, ball(900000 + 100000 * k), kNow + 100000 * k);
  const auto targets = sent<target_t>(channel::kTarget);
  ASSERT_EQ(targets.size(), 31U);
  EXPECT_EQ(targets[0].utime, 900000);
  EXPECT_EQ(targets[0].status, target_t::STATUS_TRACKED);
  EXPECT_EQ(targets[0].position_m[0], 0.1);
  EXPECT_NEAR(targets[10].position_m[0], 0.1 + 10 * 0.1 * Touch::kSpeed, 1e-12);
  EXPECT_NEAR(targets[10].velocity_m_s[0], Touch::kSpeed, 1e-12);
  EXPECT_NEAR(targets[30].position_m[0], 1.1, 1e-12);
  EXPECT_EQ(targets[30].velocity_m_s[0], 0);
  touch_.tick(kNow + Touch::kChoicePeriod, out_);
  EXPECT_EQ(sent<target_choice_t>(channel::kTargetChoice).size(), 2U);
}

TEST_F(PageTouch, WithoutOtherTargetsItCountsTheTimeItself) {
  ASSERT_TRUE(move("a", 0.1, kNow)->accepted);
  hear(channel::kTarget, ball(900000), kNow);
  for (int64_t k = 1; k <= 50; ++k) touch_.tick(kNow + 20000 * k, out_);
  const auto targets = sent<target_t>(channel::kTarget);
  ASSERT_GT(targets.size(), 15U);
  EXPECT_EQ(targets.back().utime, 900000 + 1000000 - 20000 * (50 % 2));
  for (size_t k = 1; k < targets.size(); ++k) EXPECT_GT(targets[k].utime, targets[k - 1].utime);
}

TEST_F(PageTouch, OneBrowserAtATimeMovesTheTarget) {
  ASSERT_TRUE(move("a", 0.1, kNow)->accepted);
  EXPECT_FALSE(move("b", 0.2, kNow + 1000)->accepted);
  EXPECT_FALSE(touch_.handle({{"request", "release"}, {"client", "b"}}, kNow + 2000, out_)->accepted);
  EXPECT_TRUE(move("b", 0.2, kNow + Touch::kLease)->accepted) << "the first has not been heard since";
  EXPECT_FALSE(move("a", 0.1, kNow + Touch::kLease + 1)->accepted);
  EXPECT_TRUE(touch_.handle({{"request", "release"}, {"client", "b"}}, kNow + Touch::kLease + 2, out_)->accepted);
  EXPECT_EQ(sent<target_choice_t>(channel::kTargetChoice).back().kind, target_choice_t::CONFIGURED);
  const size_t targets = sent<target_t>(channel::kTarget).size();
  touch_.tick(kNow + Touch::kLease + 1000000, out_);
  EXPECT_EQ(sent<target_t>(channel::kTarget).size(), targets) << "there is no target of the page any more";
  EXPECT_TRUE(move("a", 0.1, kNow + Touch::kLease + 3)->accepted);
}

TEST_F(PageTouch, AnotherPagesChoiceIsRespectedWhileItIsHeard) {
  target_choice_t choice{};
  choice.run = 8;
  choice.kind = target_choice_t::NAMED;
  choice.chosen_by = "the page";
  hear(channel::kTargetChoice, choice, kNow);
  EXPECT_FALSE(move("a", 0.1, kNow + 1000)->accepted);
  choice.kind = target_choice_t::CONFIGURED;
  hear(channel::kTargetChoice, choice, kNow + 2000);
  EXPECT_TRUE(move("a", 0.1, kNow + 3000)->accepted);
}

TEST_F(PageTouch, ARealRobotIsEnabledForThePagesTarget) {
  robot_state_t robot{};
  robot.simulated = false;
  hear(channel::kRobotState, robot, kNow);
  bridge_state_t bridge{};
  bridge.state = bridge_state_t::RUNNING;
  hear(channel::kBridgeState, bridge, kNow);
  EXPECT_FALSE(move("a", 0.1, kNow)->accepted) << "it was enabled for another target";
  EXPECT_TRUE(sent<target_choice_t>(channel::kTargetChoice).empty());
  EXPECT_FALSE(touch_.handle({{"request", "push"}, {"link", "hand"}, {"force_n", {1, 0, 0}}}, kNow, out_)->accepted);
  bridge.state = bridge_state_t::IDLE;
  hear(channel::kBridgeState, bridge, kNow);
  EXPECT_TRUE(move("a", 0.1, kNow)->accepted);
  bridge.state = bridge_state_t::RUNNING;
  hear(channel::kBridgeState, bridge, kNow);
  EXPECT_FALSE(move("a", 0.2, kNow)) << "it goes on";
}

TEST_F(PageTouch, ObstaclesAndPushesAreCheckedAndSent) {
  const json sphere{{"shape", "sphere"}, {"name", "page 1"}, {"position_m", {0.1, 0.2, 0.3}}, {"size_m", {0.05}}};
  EXPECT_TRUE(touch_.handle({{"request", "obstacles"}, {"obstacles", {sphere}}}, kNow, out_)->accepted);
  EXPECT_TRUE(touch_.handle({{"request", "obstacles"}, {"obstacles", json::array()}}, kNow, out_)->accepted);
  const auto lists = sent<obstacles_t>(channel::kObstacles);
  ASSERT_EQ(lists.size(), 2U);
  ASSERT_EQ(lists[0].num_obstacles, 1);
  EXPECT_EQ(lists[0].obstacles[0].name, "page 1");
  EXPECT_EQ(lists[0].obstacles[0].size_m[0], 0.05);
  EXPECT_EQ(lists[1].num_obstacles, 0);
  EXPECT_GT(lists[1].sequence, lists[0].sequence);
  for (const json& wrong : {json{{"shape", "cone"}, {"position_m", {0, 0, 0}}, {"size_m", {1}}},
                            json{{"shape", "sphere"}, {"position_m", {0, 0}}, {"size_m", {1}}},
                            json{{"shape", "sphere"}, {"position_m", {0, 0, 0}}, {"size_m", {-1}}}, json(3)})
    EXPECT_FALSE(touch_.handle({{"request", "obstacles"}, {"obstacles", {wrong}}}, kNow, out_)->accepted) << wrong;
  EXPECT_TRUE(touch_.handle({{"request", "push"}, {"link", "hand"}, {"force_n", {0, 5, 0}}}, kNow, out_)->accepted);
  const auto pushes = sent<perturbation_t>(channel::kPerturbation);
  ASSERT_EQ(pushes.size(), 1U);
  EXPECT_EQ(pushes[0].link_name, "hand");
  EXPECT_EQ(pushes[0].force_n[1], 5);
  for (const json& force : {json{1e9, 0, 0}, json{1, 2}, json("x")})
    EXPECT_FALSE(touch_.handle({{"request", "push"}, {"link", "hand"}, {"force_n", force}}, kNow, out_)->accepted);
  EXPECT_EQ(sent<perturbation_t>(channel::kPerturbation).size(), 1U);
}

}  // namespace
}  // namespace multireach
