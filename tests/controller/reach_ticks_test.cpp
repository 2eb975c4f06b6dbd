#include <gtest/gtest.h>

#include <map>

#include "controller/reach_controller.hpp"
#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr int64_t kFrame = 33334;  // us

/// When ReachController ticks, with targets at times of their own.
class ReachTicks : public ::testing::Test {
 protected:
  ReachController controller(const ReachOptions& options = {}) const {
    ReachController c(testing::hoap2(), options);
    JointVector start(4);
    start << 0.2, -0.3, -0.2, -0.9;
    EXPECT_TRUE(c.start(start));
    return c;
  }

  Eigen::Vector3d front_{0.10, -0.12, 0.10};
  int64_t now_ = 1000000000;
};

// Targets at 30 Hz, between the ticks of 20 Hz: each is taken up by a tick that is less than one integration step
// older.
TEST_F(ReachTicks, TicksWhenATargetComesAndTakesTheSameWay) {
  ReachOptions periodic;
  periodic.ticks = TickTimes::kPeriodic;
  ReachController early = controller(), grid = controller(periodic);
  early.restart_grid(now_);
  grid.restart_grid(now_);
  std::map<int64_t, JointVector> way;  // by time: the ticks of both are whole integration steps after the first
  int64_t frame = now_;
  for (int k = 0; k < 90; ++k, frame += kFrame) {
    ASSERT_TRUE(early.observe({.utime = frame, .seen = true, .position = front_}));
    EXPECT_TRUE(early.target_waits());
    EXPECT_LE(*early.next_tick(), frame);
    EXPECT_LT(frame - *early.next_tick(), 50000 / 7 + 1);
    const ReachOutput out = early.tick();
    EXPECT_FALSE(early.target_waits());
    EXPECT_EQ(*early.next_tick() - out.utime, 50000);
    way[out.utime] = out.theta;
  }
  int compared = 0;
  ASSERT_TRUE(grid.observe({.utime = now_, .seen = true, .position = front_}));
  while (*grid.next_tick() < frame) {
    grid.observe({.utime = *grid.next_tick(), .seen = true, .position = front_});
    const ReachOutput out = grid.tick();
    const auto same = way.find(out.utime);
    if (same == way.end()) continue;
    ++compared;
    EXPECT_EQ(same->second, out.theta) << out.utime - now_;
  }
  EXPECT_GE(compared, 20);
}

TEST_F(ReachTicks, TicksOnceInAQuarterOfThePeriodAtMostHoweverManyTargetsCome) {
  ReachController c = controller();
  c.restart_grid(now_);
  int64_t ticks = 0, last = now_ - 50000;
  for (int64_t time = now_; time < now_ + 2000000; time += 1000) {
    ASSERT_TRUE(c.observe({.utime = time, .seen = true, .position = front_}));
    if (*c.next_tick() > time) continue;
    const ReachOutput out = c.tick();
    EXPECT_GE(out.utime - last, 12500);
    last = out.utime;
    ++ticks;
  }
  EXPECT_LE(ticks, 160);
}

}  // namespace
}  // namespace multireach::controller
