#include <gtest/gtest.h>

#include "runtime/channels.hpp"
#include "tools/robot/hand_status.hpp"
#include "tools/view/view_node.hpp"

namespace multireach {
namespace {

constexpr int64_t kMillisecond = 1000;

controller_state_t reaching(double distance_m) {
  controller_state_t state{};
  state.mode = controller_state_t::MODE_REACHING;
  state.distance_m = distance_m;
  return state;
}

node_status_t status(const std::string& node, const std::string& state) {
  node_status_t status{};
  status.node = node;
  status.state = state;
  return status;
}

TEST(HandStatus, SaysHowFarTheHandIsAndWhatIsInTheWay) {
  EXPECT_EQ(text_of(controller_state_t{}), "waiting for a target") << "without a target, there is no distance";
  controller_state_t state = reaching(0.01234);
  EXPECT_EQ(text_of(state), "reaching, hand 12.3 mm from the target");
  state.blocked = controller_state_t::BLOCKED_BY_OBSTACLE;
  EXPECT_EQ(text_of(state),
            "reaching, hand 12.3 mm from the target; blocked: an obstacle or the arm itself is in the way");
  state = reaching(0.1);
  state.mode = controller_state_t::MODE_HOLDING;
  state.target_lost = state.target_unreachable = true;
  EXPECT_EQ(text_of(state), "holding, hand 100.0 mm from the target as last seen, which is unreachable");
  state.mode = state.blocked = 17;  // of a later version
  EXPECT_EQ(text_of(state),
            "unknown, hand 100.0 mm from the target as last seen, which is unreachable; blocked: no way found");
}

TEST(HandStatus, WaitsForAControllerThatIsHeardLate) {
  const int64_t begin = 5000 * kMillisecond;
  HandStatus hand(begin);
  EXPECT_FALSE(hand.line(begin));
  EXPECT_FALSE(hand.line(begin + 1900 * kMillisecond)) << "it may still be heard";
  hand.receive(status("bridge", "running"));
  EXPECT_FALSE(hand.line(begin + 1900 * kMillisecond)) << "another node is no controller";
  hand.receive(reaching(0.004));
  EXPECT_EQ(hand.line(begin + 1900 * kMillisecond), "controller: reaching, hand 4.0 mm from the target");
}

TEST(HandStatus, SaysWhatTheControllerWaitsForBeforeItsFirstTarget) {
  HandStatus hand(0);
  hand.receive(status("controller", "waiting for the robot"));
  EXPECT_EQ(hand.line(0), "controller: waiting for the robot");
  hand.receive(reaching(0.004));
  hand.receive(status("controller", "reaching"));
  EXPECT_EQ(hand.line(0), "controller: reaching, hand 4.0 mm from the target") << "which tells more";
}

TEST(HandStatus, SaysForHowLongNoControllerWasHeard) {
  const HandStatus hand(0);
  EXPECT_FALSE(hand.line(HandStatus::kPatience - 1));
  EXPECT_EQ(hand.line(HandStatus::kPatience), "controller: not heard in 2.0 s");
}

class StatusLine : public ::testing::Test {
 protected:
  void hear(const std::string& node, const std::string& state) {
    view_.receive(channel::kNodeStatus, *encode(status(node, state)), out_);
  }
  void wait(int seconds) {
    for (int i = 0; i < 4 * seconds; ++i) view_.tick(out_);
  }
  bool says(const std::string& words) const { return view_.line().find(words) != std::string::npos; }

  ViewNode view_{RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml"), {.wait_for = {"nobody"}}};
  Outbox out_;
};

TEST_F(StatusLine, ShowsAPauseUntilTheBridgeIsNoLongerHeard) {
  EXPECT_TRUE(says("bridge not heard in 0 s")) << view_.line();
  hear("bridge", "stopping: paused; 3 commands refused");
  hear("controller", "reaching");
  wait(2);
  EXPECT_TRUE(says("controller reaching | bridge stopping: paused")) << view_.line();
  EXPECT_FALSE(says("refused")) << view_.line();
  wait(2);
  hear("controller", "reaching");
  EXPECT_TRUE(says("controller reaching | bridge not heard in 4 s")) << view_.line();
  hear("bridge", "running");
  EXPECT_TRUE(says("bridge running")) << view_.line();
}

}  // namespace
}  // namespace multireach
