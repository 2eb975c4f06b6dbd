// What a driver sends where commands are missing, come in bursts, or begin elsewhere: limits by differences of what is
// sent in each millisecond.
#include "robot_bridge/drivers/command_follower.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "numeric/random.hpp"

namespace multireach::drivers {
namespace {

robot_bridge::MotionLimits limits() {
  const JointVector one = JointVector::Ones(1);
  return {-3 * one, 3 * one, 2 * one, 20 * one, 2000 * one};
}

/// Commands of 2 sin(t / 2) at 1 kHz reach the follower one millisecond after their time.
class Following : public ::testing::Test {
 protected:
  static double q(double t) { return 2 * std::sin(t / 2); }
  static double v(double t) { return std::cos(t / 2); }

  void give(int64_t ms) {
    const double t = static_cast<double>(ms) * 1e-3;
    sent_ = follower.command(JointVector::Constant(1, q(t)), JointVector::Constant(1, v(t)), ms * 1000, arm, now_us);
  }
  /// The end of a millisecond.
  void tick() {
    int64_t utime = 0;
    if (const auto* state = follower.missing(now_us, utime)) sent_ = *state;
    now_us += 1000;
    if (!sent_) return positions.clear();
    positions.push_back(sent_->position[0]);
    const size_t n = positions.size();
    if (n >= 2) fastest = std::max(fastest, std::abs(positions[n - 1] - positions[n - 2]) * 1e3);
    if (n >= 3) {
      hardest = std::max(hardest, std::abs(positions[n - 1] - 2 * positions[n - 2] + positions[n - 3]) * 1e6);
    }
    if (follower.following()) return;
    arm = sent_->position;
    sent_.reset();
  }

  /// Follows from standstill for a second. Returns the time of the next command, ms.
  int64_t begin() {
    follower.forget();
    sent_.reset();
    positions.clear();
    arm[0] = q(0);
    for (int64_t ms = 0; ms < 1000; ++ms) {
      give(ms);
      tick();
    }
    fastest = hardest = 0;
    return 1000;
  }

  CommandFollower follower{limits(), 20000};
  JointVector arm = JointVector::Zero(1);
  int64_t now_us = 1000;
  std::optional<robot_bridge::MotionState> sent_;
  std::vector<double> positions;
  double fastest = 0, hardest = 0;
};

TEST_F(Following, PassesCommandsOnUnchanged) {
  arm[0] = q(1);
  give(1000);
  tick();
  for (int64_t ms = 1001; ms < 2000; ++ms) {
    give(ms);
    if (ms > 1500) {
      EXPECT_EQ(sent_->position[0], q(static_cast<double>(ms) * 1e-3)) << "the start is over";
    }
    tick();
  }
  EXPECT_LT(hardest, 1.5 * 20);
}

TEST_F(Following, AGapWithinTheTimeOutIsASmoothDetour) {
  for (int gap = 1; gap <= 18; ++gap) {
    SCOPED_TRACE(gap);
    int64_t ms = begin();
    for (int k = 0; k < gap; ++k, ++ms) tick();
    for (int k = 0; k < 1000; ++k, ++ms) {
      ASSERT_FALSE(follower.stopping());
      give(ms);
      tick();
    }
    EXPECT_NEAR(positions.back(), q(static_cast<double>(ms - 1) * 1e-3), 1e-9);
    EXPECT_LT(fastest, 2 * 1.5);
    EXPECT_LT(hardest, 20 * 1.5 * 1.02);
  }
}

TEST_F(Following, CommandsThatComeTogetherAfterAGapAreNoStep) {
  for (const int gap : {3, 8, 15}) {
    for (const bool all_at_once : {true, false}) {
      SCOPED_TRACE(gap);
      int64_t ms = begin();
      for (int k = 0; k < gap; ++k) tick();
      // Those of the gap, in one burst or all later by the gap from now on.
      for (int k = 0; all_at_once && k < gap; ++k) give(ms++);
      for (int k = 0; k < 1000; ++k) {
        give(ms++);
        tick();
      }
      EXPECT_NEAR(positions.back(), q(static_cast<double>(ms - 1) * 1e-3), 1e-9);
      EXPECT_LT(fastest, 2 * 1.5);
      EXPECT_LT(hardest, 20 * 1.5 * 1.02);
    }
  }
}

TEST_F(Following, ALongGapEndsInARampToStandstill) {
  int64_t ms = 0;
  for (; ms < 1000; ++ms) {
    give(ms);
    tick();
  }
  fastest = hardest = 0;
  int ticks = 0;
  for (; follower.following() && ticks < 1000; ++ticks) tick();
  EXPECT_LT(ticks, 200);
  EXPECT_LT(fastest, 0.9) << "cos(0.5) at the last command";
  EXPECT_LT(hardest, 20 * 1.02);
  EXPECT_GT(ticks, 20) << "of the time-out";
}

// Commands that have waited come many in a millisecond, or most of them are lost.
TEST_F(Following, CommandsThatLeapInTimeAreJoinedSmoothly) {
  for (const int64_t together : {4, 5, 15, 40}) {
    for (const int64_t lost : {0, 3, 30}) {
      SCOPED_TRACE(std::to_string(together) + " in a millisecond, then " + std::to_string(lost) + " lost");
      int64_t ms = begin();
      for (int k = 0; k < 2; ++k) tick();  // as late as without a transition
      fastest = hardest = 0;
      for (int64_t behind = 60; behind > 1;) {
        for (int64_t k = 0; k < together && behind > 0; ++k, --behind) give(ms++);
        tick();
        ++behind;
      }
      ms += lost;
      for (int k = 0; k < 1000; ++k) {
        give(ms++);
        tick();
      }
      EXPECT_NEAR(positions.back(), q(static_cast<double>(ms - 1) * 1e-3), 1e-9);
      EXPECT_LT(fastest, 4) << "two commands in a millisecond are passed on: twice the speed, and half of the limit";
    }
  }
}

// The driver itself is stopped: the robot rests at what it got last, so that nothing else may come next.
TEST_F(Following, AfterAStopOfTheDriverTheMotionBeginsAgainFromRest) {
  for (const bool command_first : {false, true}) {
    for (const int64_t stopped_ms : {4, 25, 100, 600}) {
      SCOPED_TRACE(std::to_string(stopped_ms) + (command_first ? " ms, a command first" : " ms, a tick first"));
      int64_t ms = begin();
      const double last = sent_->position[0];
      now_us += 1000 * stopped_ms;
      follower.hold(now_us);
      arm[0] = last;
      fastest = hardest = 0;
      positions.assign(3, last);
      if (command_first) {
        give(ms++);  // those that waited
        EXPECT_NEAR(sent_->position[0], last, 1e-12);
        give(ms++);
        EXPECT_NEAR(sent_->position[0], last, 1e-12);
      } else {
        int64_t utime = 0;
        EXPECT_EQ(follower.missing(now_us, utime), nullptr);
        EXPECT_FALSE(follower.following());
      }
      ms += stopped_ms;
      for (int k = 0; k < 2000; ++k) {
        give(ms++);
        tick();
      }
      EXPECT_NEAR(positions.back(), q(static_cast<double>(ms - 1) * 1e-3), 1e-9);
      EXPECT_LT(fastest, 2 * 1.5);
      EXPECT_LT(hardest, 20 * 1.5 * 1.02);
    }
  }
}

// After a pause of all processes, the bridge begins again from rest while the arm still moves; then commands and
// milliseconds come in a random order, as where both clocks tick at the same time. Each missing command once began the
// transition anew, so the arm kept its speed beside that of the commands: twice the limit.
TEST_F(Following, ArrivesAtTheCommandsHoweverOftenOneMissesItsMillisecond) {
  // A quintic that begins with 1.9 rad/s decelerates by at most 10 rad/s^2, half of the limit, in 0.75 s, or up to a
  // tenth longer; it passes 0.198 of speed times duration, beside what the arm went in 9 ms.
  constexpr double kFarthest = 0.198 * 1.9 * 1.1 * 0.75 + 9e-3 * 1.9;
  const CounterRandom random(31);
  uint64_t counter = 0;
  for (int run = 0; run < 100; ++run) {
    SCOPED_TRACE("seed 31, run " + std::to_string(run));
    const double late_share = random.uniform(counter++, 0, 0.6);
    follower.forget();
    sent_.reset();
    positions.clear();
    const auto command = [&](double position, double velocity, int64_t ms) {
      sent_ = follower.command(JointVector::Constant(1, position), JointVector::Constant(1, velocity), ms * 1000, arm,
                               now_us);
    };
    // 1.9 rad/s of 2, then 9 ms without commands, then from rest with 10 rad/s^2 to 1.9 rad/s again.
    arm[0] = -2;
    int64_t ms = 0;
    for (; ms < 1000; ++ms) {
      command(-2 + 1.9e-3 * static_cast<double>(ms), 1.9, ms);
      tick();
    }
    for (int k = 0; k < 9; ++k) tick();
    fastest = hardest = 0;
    const double begin = -2 + 1.9;
    int waiting = 0;
    double position = 0;
    const auto next = [&](int k) {
      const double t = 1e-3 * k, ramp = 0.19;
      position = begin + (t < ramp ? 5 * t * t : 5 * ramp * ramp + 1.9 * (t - ramp));
      command(position, std::min(10 * t, 1.9), ms + k);
    };
    for (int k = 0; k < 1000; ++k) {
      ++waiting;
      if (random.uniform(counter++) >= late_share) {
        for (; waiting > 0; --waiting) next(k + 1 - waiting);
      }
      tick();
      EXPECT_LT(std::abs(positions.back() - position), kFarthest + 3e-3 * waiting)
          << k << ": at most 3 rad/s more while commands wait";
    }
    EXPECT_NEAR(positions.back(), position, 0.02) << "the commands of some milliseconds";
    EXPECT_LT(fastest, 2 * 1.5);
  }
}

// Random losses, pauses and bursts of random joints' states: no step, whatever comes when.
TEST_F(Following, NoScheduleOfCommandsMakesAStep) {
  const CounterRandom random(11);
  uint64_t counter = 0;
  const auto number = [&](double end) { return random.uniform(counter++, 0, end); };
  for (int run = 0; run < 300; ++run) {
    SCOPED_TRACE("seed 11, run " + std::to_string(run));
    follower.forget();
    sent_.reset();
    positions.clear();
    fastest = hardest = 0;
    int64_t ms = static_cast<int64_t>(number(5000));
    arm[0] = q(static_cast<double>(ms) * 1e-3) + number(0.2) - 0.1;
    int pause = 0, waiting = 0;
    for (int k = 0; k < 3000; ++k) {
      if (pause == 0 && number(1) < 0.01) pause = static_cast<int>(number(1) < 0.7 ? number(15) : number(60));
      if (pause > 0) {
        --pause;
        waiting += number(1) < 0.5 ? 1 : 0;
        ms += 1;
      } else {
        for (; waiting > 0 && !follower.stopping(); --waiting) give(ms - waiting);
        waiting = 0;
        if (!follower.stopping()) give(ms);
        ++ms;
      }
      const double last = positions.empty() ? NAN : positions.back();
      tick();
      if (!positions.empty() && !std::isnan(last)) {
        EXPECT_LT(std::abs(positions.back() - last), 2 * 1.5e-3);
      }
    }
    EXPECT_LT(fastest, 2 * 1.5);
    EXPECT_LT(hardest, 20 * 1.55);
  }
}

// The quintics that decay against their derivatives by differences.
TEST(JoinBlend, KeepsHalfOfTheLimitsAndItsDerivativesAreTrue) {
  const CounterRandom random(5);
  uint64_t counter = 0;
  for (int k = 0; k < 500; ++k) {
    SCOPED_TRACE("seed 5, blend " + std::to_string(k));
    const JointVector position = JointVector::Constant(1, random.uniform(counter++, -0.3, 0.3));
    const JointVector velocity = JointVector::Constant(1, k % 2 ? random.uniform(counter++, -2, 2) : 0);
    const JoinBlend blend(limits(), {position, velocity, {}});
    const auto at = [&](double t) {
      auto state = robot_bridge::MotionState::at_rest(JointVector::Zero(1));
      blend.apply(t, state);
      return state;
    };
    EXPECT_DOUBLE_EQ(at(0).position[0], position[0]);
    EXPECT_DOUBLE_EQ(at(0).velocity[0], velocity[0]);
    EXPECT_EQ(at(0).acceleration[0], 0);
    const double most_v = std::max(1.0, std::abs(velocity[0]));
    constexpr double kStep = 1e-5;
    for (double t = kStep; !blend.over(t + kStep); t += 3.7e-3) {
      const auto state = at(t), before = at(t - kStep), after = at(t + kStep);
      EXPECT_NEAR(state.velocity[0], (after.position[0] - before.position[0]) / (2 * kStep), 1e-4);
      EXPECT_NEAR(state.acceleration[0], (after.velocity[0] - before.velocity[0]) / (2 * kStep), 1e-2);
      EXPECT_LE(std::abs(state.velocity[0]), most_v * 1.001);
      EXPECT_LE(std::abs(state.acceleration[0]), 10 * 1.01);
      EXPECT_LE(std::abs(after.acceleration[0] - before.acceleration[0]) / (2 * kStep), 1000 * 1.05);
    }
    EXPECT_TRUE(blend.over(60));
    EXPECT_EQ(at(60).position[0], 0);
  }
}

}  // namespace
}  // namespace multireach::drivers
