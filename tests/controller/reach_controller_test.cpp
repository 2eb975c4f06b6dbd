#include "controller/reach_controller.hpp"

#include <gtest/gtest.h>

#include "tests/allocation_count.hpp"
#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr int64_t kFrame = 33333;  // us

class Reaching : public ::testing::Test {
 protected:
  Reaching() { start_ << 0.2, -0.3, -0.2, -0.9; }

  ReachController controller(const ReachOptions& options = {}) const {
    ReachController c(chain_, options);
    EXPECT_TRUE(c.start(start_));
    return c;
  }

  /// Runs `seconds` of a target that `place` gives at each frame (nothing: not seen), and returns the last output.
  /// Between two ticks no joint may move further than a joint can.
  template <class Place>
  ReachOutput run(ReachController& c, double seconds, Place&& place) {
    const int64_t end = now_ + static_cast<int64_t>(seconds * 1e6);
    ReachOutput last;
    if (!c.next_tick()) c.restart_grid(now_);
    for (int64_t frame = now_; frame < end; frame += kFrame) {
      const std::optional<Eigen::Vector3d> p = place(static_cast<double>(frame - now_) * 1e-6);
      EXPECT_TRUE(c.observe({.utime = frame, .seen = p.has_value(), .position = p.value_or(Eigen::Vector3d::Zero())}));
      while (*c.next_tick() <= frame) {
        const ReachOutput out = c.tick();
        if (previous_.size() > 0) {
          EXPECT_LT((out.theta - previous_).cwiseAbs().maxCoeff(), 0.6) << out.utime;
        }
        EXPECT_TRUE(out.theta.allFinite());
        previous_ = out.theta;
        last = out;
      }
    }
    now_ = end;
    return last;
  }

  Chain chain_ = testing::hoap2();
  JointVector start_{4}, previous_;
  Eigen::Vector3d front_{0.10, -0.12, 0.10}, side_{0.05, -0.22, 0.10}, far_{0.4, -0.1, 0.1};
  int64_t now_ = 1000000000;
};

TEST_F(Reaching, WaitsWhereItIsUntilATargetIsSeen) {
  ReachController c = controller();
  const ReachOutput out = run(c, 1, [](double) { return std::nullopt; });
  EXPECT_EQ(out.mode, ReachMode::kWaiting);
  EXPECT_TRUE(out.target_lost);
  EXPECT_EQ(out.theta, start_);
  EXPECT_EQ(out.velocity.norm(), 0);
}

TEST_F(Reaching, TicksOnAnIntegerGridFromItsFirstTarget) {
  ReachController c = controller();
  c.restart_grid(now_);
  ASSERT_TRUE(c.observe({.utime = now_, .seen = true, .position = front_}));
  for (int64_t k = 0; k < 5; ++k) {
    EXPECT_EQ(*c.next_tick(), now_ + 50000 * k);
    EXPECT_EQ(c.tick().tick, k);
  }
}

TEST_F(Reaching, ReachesAStillTarget) {
  ReachController c = controller();
  const ReachOutput out = run(c, 3, [&](double) { return front_; });
  EXPECT_EQ(out.mode, ReachMode::kReaching);
  EXPECT_LT((out.x - front_).norm(), 1e-4);
  EXPECT_EQ(chain_.limit_excess(out.theta), 0);
}

TEST_F(Reaching, FollowsAMovingTarget) {
  ReachController c = controller();
  run(c, 2, [&](double) { return front_; });
  const ReachOutput out = run(c, 3, [&](double t) { return Eigen::Vector3d(front_ + (side_ - front_) * t / 3); });
  EXPECT_EQ(out.mode, ReachMode::kReaching);
  EXPECT_LT((out.x - side_).norm(), 0.02) << "it lags behind by the attractor's delay";
  EXPECT_LT((run(c, 2, [&](double) { return side_; }).x - side_).norm(), 1e-3);
}

TEST_F(Reaching, ChoosesAPostureAnewWhenTheTargetJumps) {
  ReachController c = controller();
  const int64_t before = run(c, 2, [&](double) { return front_; }).posture_choices;
  const ReachOutput out = run(c, 2.5, [&](double) { return side_; });
  EXPECT_EQ(out.posture_choices, before + 1);
  EXPECT_LT((out.x - side_).norm(), 1e-3);
}

TEST_F(Reaching, GoesOnToTheLastTargetWhenItIsLost) {
  ReachController c = controller();
  run(c, 0.3, [&](double) { return front_; });
  const ReachOutput out = run(c, 3, [](double) { return std::nullopt; });
  EXPECT_EQ(out.mode, ReachMode::kHolding);
  EXPECT_TRUE(out.target_lost);
  EXPECT_LT((out.x - front_).norm(), 1e-4);
  EXPECT_EQ(run(c, 1, [&](double) { return front_; }).mode, ReachMode::kReaching) << "and takes it up again";
}

TEST_F(Reaching, GoesToRestWhenItIsLostAndToldSo) {
  ReachOptions options;
  options.without_target = WithoutTarget::kGoToRest;
  options.rest = JointVector(4);
  options.rest << 0.1, -0.5, -0.1, -0.5;
  ReachController c = controller(options);
  run(c, 2, [&](double) { return front_; });
  const ReachOutput out = run(c, 4, [](double) { return std::nullopt; });
  EXPECT_EQ(out.mode, ReachMode::kResting);
  EXPECT_LT((out.theta - options.rest).norm(), 1e-3);
  EXPECT_LT((run(c, 3, [&](double) { return front_; }).x - front_).norm(), 1e-3);
}

TEST_F(Reaching, KeepsTheLastReachableTargetWhenTheTargetGoesOutOfReach) {
  for (const bool jumps : {true, false}) {
    ReachController c = controller();
    run(c, 2, [&](double) { return front_; });
    const ReachOutput out = run(
        c, 3, [&](double t) { return jumps ? far_ : Eigen::Vector3d(front_ + (far_ - front_) * std::min(t, 1.0)); });
    EXPECT_EQ(out.mode, ReachMode::kHolding);
    EXPECT_TRUE(out.target_out_of_reach);
    EXPECT_LT(out.velocity.norm(), 1e-3) << "calm";
    EXPECT_LT(chain_.limit_excess(out.theta), 0.05);
    EXPECT_LT((run(c, 3, [&](double) { return front_; }).x - front_).norm(), 1e-3) << "and comes back";
    previous_.resize(0);
  }
}

TEST_F(Reaching, RefusesWhatIsNotFiniteOrOlder) {
  ReachController c(chain_, {});
  JointVector bad = start_;
  bad[1] = NAN;
  EXPECT_FALSE(c.start(bad));
  EXPECT_FALSE(c.start(JointVector::Zero(3)));
  EXPECT_TRUE(c.start(start_));
  EXPECT_TRUE(c.observe({.utime = 1000, .seen = true, .position = front_}));
  EXPECT_FALSE(c.observe({.utime = 2000, .seen = true, .position = {0, INFINITY, 0}}));
  EXPECT_FALSE(c.observe({.utime = 999, .seen = true, .position = side_}));
  EXPECT_TRUE(c.observe({.utime = 1000, .seen = true, .position = front_})) << "a duplicate is harmless";
}

TEST_F(Reaching, RefusesOptionsThatMakeNoSense) {
  ReachOptions options;
  options.law.gamma = -1;
  EXPECT_THROW(ReachController(chain_, options), std::invalid_argument);
  options = {};
  options.steps_per_tick = 0;
  EXPECT_THROW(ReachController(chain_, options), std::invalid_argument);
  options = {};
  options.rest = JointVector::Constant(4, 3.0);
  EXPECT_THROW(ReachController(chain_, options), std::invalid_argument);
}

TEST_F(Reaching, TheSameInputsGiveTheSameBits) {
  const auto all = [&] {
    now_ = 0;
    previous_.resize(0);
    ReachController c = controller();
    const JointVector a = run(c, 1, [&](double) { return front_; }).theta;
    const JointVector b =
        run(c, 1, [&](double t) { return Eigen::Vector3d(side_ + Eigen::Vector3d(0, 0, 0.02 * t)); }).theta;
    JointVector both(8);
    both << a, b;
    return both;
  };
  EXPECT_EQ(all(), all());
}

TEST_F(Reaching, TheTickAllocatesNothing) {
  ReachController c = controller();
  run(c, 0.5, [&](double) { return front_; });
  const int64_t before = testing::allocations().number;
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d p = (k / 20) % 2 ? front_ : side_;  // jumps, so that postures are chosen too
    c.observe({.utime = *c.next_tick(), .seen = true, .position = p});
    c.tick();
  }
  EXPECT_EQ(testing::allocations().number, before);
  operator delete(operator new(8));
  EXPECT_EQ(testing::allocations().number, before + 1) << "the count can fail";
}

}  // namespace
}  // namespace multireach::controller
