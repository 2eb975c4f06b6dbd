// Each driver against its emulator, in virtual time: long motions, and seeded faults of the connection and the robot.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "tests/robot_bridge/drivers/driver_loop.hpp"

namespace multireach::testing {
namespace {

int64_t from_environment(const char* name, int64_t otherwise) {
  const char* text = std::getenv(name);
  return text ? std::atoll(text) : otherwise;
}

RobotConfig robot_or_test_robot(const std::string& name) {
  if (name != "so101_dynamixel") return robot_named(name);
  return RobotConfig::load(MULTIREACH_SOURCE_DIR "/tests/data/so101_dynamixel/robot.yaml");
}

class Drivers : public ::testing::TestWithParam<const char*> {};

TEST_P(Drivers, MoveForLongWithoutARefusal) {
  DriverLoop loop(robot_or_test_robot(GetParam()));
  const int64_t seconds = from_environment("MULTIREACH_DRIVER_SECONDS", 20);
  loop.run(15000);  // the slowest start of a controller, and the first set-points
  ASSERT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.driver().state() << "; " << loop.bridge().state();
  loop.fastest_share = 0;
  const int64_t refused_before = loop.driver().counters().refused;
  loop.run(1000 * seconds);
  EXPECT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.driver().state() << "; " << loop.bridge().state();
  EXPECT_EQ(loop.emulator().fault(), "");
  EXPECT_EQ(loop.driver().counters().refused, refused_before) << loop.driver().state();
  EXPECT_EQ(loop.driver().counters().dropped, 0);
  EXPECT_GT(loop.fastest_share, 0.15) << "the arm moves";
  EXPECT_LT(loop.commands.fastest, 1.001);
  EXPECT_LT(loop.commands.hardest, 1.02) << "a difference of positions, of a motion with jerk";
  EXPECT_LT(loop.fastest_share, 1.1);
}

// The commands keep the limits; where a driver joins them after a gap, it adds at most half of each limit.
constexpr double kLargestShare = 1.55;

/// One seeded fault, for a random time, in the middle of a motion. Returns its name.
std::string inject(DriverLoop& loop, const CounterRandom& random, int64_t& lasts_ms) {
  lasts_ms = static_cast<int64_t>(random.uniform(1, 5, 3000));
  switch (static_cast<int>(random.uniform(2, 0, 10))) {
    case 0:
      loop.faults.cut = true;
      return "the wire is cut";
    case 1:
      loop.faults.delay_ms = static_cast<int64_t>(random.uniform(3, 2, 40));
      return "delay of " + std::to_string(loop.faults.delay_ms) + " ms";
    case 2:
      loop.faults.loss = random.uniform(3, 0.01, 0.5);
      loop.faults.corruption = loop.faults.loss;
      return "loss";
    case 3:
      loop.emulator().collide();
      return "a collision";
    case 4:
      loop.bridge_stalls = true;
      return "the bridge stalls";
    case 5:
      loop.sends_setpoints = false;
      return "no set-points";
    case 6:
      loop.command_loss = random.uniform(3, 0.01, 0.9);
      return "loss of commands";
    case 7:
      loop.commands_held_until_ms = loop.now_ms() + static_cast<int64_t>(random.uniform(3, 1, 60));
      return "a gap in the commands";
    case 8:
      loop.driver_stalled_until_ms = loop.now_ms() + static_cast<int64_t>(std::pow(10.0, random.uniform(3, 0.7, 3.3)));
      return "the driver is stopped for " + std::to_string(loop.driver_stalled_until_ms - loop.now_ms()) + " ms";
    default:
      loop.emulator().restart();
      return "the robot's controller is restarted";
  }
}

TEST_P(Drivers, StopOnARampOrByTheRobotItselfAndRecover) {
  const int64_t schedules = from_environment("MULTIREACH_DRIVER_FAULTS", 8);
  for (int64_t seed = 1; seed <= schedules; ++seed) {
    DriverLoop loop(robot_or_test_robot(GetParam()));
    loop.run(15000);
    ASSERT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING) << loop.driver().state();
    const CounterRandom random(static_cast<uint64_t>(seed));
    loop.run(static_cast<int64_t>(random.uniform(0, 0, 4000)));
    int64_t lasts_ms = 0;
    loop.faults.random = CounterRandom(static_cast<uint64_t>(seed) + 1000);
    const std::string fault = inject(loop, random, lasts_ms);
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + fault + " for " + std::to_string(lasts_ms) + " ms");
    loop.run(lasts_ms);
    // Whatever happened, every state has its sentence, and no joint was faster than the manufacturer allows.
    EXPECT_FALSE(loop.driver().state().empty());
    EXPECT_LT(loop.fastest_share, 3.05) << "three times the gentle limit is the maker's";
    EXPECT_TRUE(loop.recover()) << "driver: " << loop.driver().state() << "; bridge: " << loop.bridge().state()
                                << "; emulator: " << loop.emulator().fault();
    EXPECT_LT(loop.fastest_share, 3.05) << "also while it recovers";
    EXPECT_LT(loop.commands.fastest, kLargestShare) << "on the wire";
    EXPECT_LT(loop.commands.hardest, kLargestShare) << "on the wire";
    EXPECT_LT(loop.commands.largest_step, kLargestShare) << "on the wire";
  }
}

TEST_P(Drivers, WithoutCommandsTheArmStandsStillSoonAfterTheTimeOut) {
  DriverLoop loop(robot_or_test_robot(GetParam()));
  loop.run(15000);
  ASSERT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING);
  loop.run(900);  // in motion
  loop.bridge_stalls = true;
  loop.run(1000);
  const JointVector there = loop.emulator().position();
  loop.run(500);
  EXPECT_LT((loop.emulator().position() - there).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_LT(loop.fastest_share, 1.1) << "no faster while it stops";
  EXPECT_LT(loop.commands.fastest, 1.001);
  EXPECT_LT(loop.commands.hardest, 1.02);
}

// The driver once sent the end of what it would have commanded meanwhile as one step.
TEST_P(Drivers, ADriverThatWasStoppedBeginsAgainFromRest) {
  for (const int64_t ms : {2, 4, 8, 25, 100, 700}) {
    SCOPED_TRACE(std::to_string(ms) + " ms");
    DriverLoop loop(robot_or_test_robot(GetParam()));
    loop.run(15000);
    ASSERT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING);
    loop.run(900);  // in motion
    loop.driver_stalled_until_ms = loop.now_ms() + ms;
    loop.run(ms + 1500);
    const double periods = ms <= 3 ? static_cast<double>(ms + 1) : 1;  // a short gap is bridged at its velocity
    EXPECT_LT(loop.commands.fastest, periods * kLargestShare) << "on the wire";
    if (ms > 3) {
      EXPECT_LT(loop.commands.hardest, kLargestShare) << "on the wire";
    }
    EXPECT_LT(loop.commands.largest_step, kLargestShare) << "on the wire";
    EXPECT_TRUE(loop.bridge_state.state == bridge_state_t::RUNNING || loop.recover())
        << "driver: " << loop.driver().state() << "; bridge: " << loop.bridge().state();
  }
}

// The user ends the driver in the middle of a motion, and the bridge goes on.
TEST_P(Drivers, ADriverThatIsEndedDeceleratesTheArmFirst) {
  DriverLoop loop(robot_or_test_robot(GetParam()));
  loop.run(15000);
  ASSERT_EQ(loop.bridge_state.state, bridge_state_t::RUNNING);
  loop.run(900);
  EXPECT_FALSE(loop.driver().finished());
  EXPECT_TRUE(loop.driver().begin_end());
  EXPECT_FALSE(loop.driver().finished()) << "in motion";
  int64_t ms = 0;
  for (; !loop.driver().finished() && ms < 2000; ++ms) loop.run(1);
  EXPECT_LT(ms, 1000);
  const JointVector there = loop.emulator().position();
  loop.run(500);
  EXPECT_LT((loop.emulator().position() - there).cwiseAbs().maxCoeff(), 0.02) << "the robot's own lag";
  EXPECT_LT(loop.commands.fastest, 1.001);
  EXPECT_LT(loop.commands.hardest, 1.02);
}

INSTANTIATE_TEST_SUITE_P(All, Drivers,
                         ::testing::Values("iiwa14", "panda", "fr3", "ur5e", "ur5", "so101", "so101_dynamixel"),
                         [](const auto& each) { return std::string(each.param); });

}  // namespace
}  // namespace multireach::testing
