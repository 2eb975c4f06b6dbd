#include "controller/reach_controller.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "numeric/random.hpp"
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

  /// Runs the controller for `seconds` and returns the last output. `position` gives the target position at each frame,
  /// or nothing when the target is not seen. Checks that no joint moves more between two ticks than its speed allows.
  template <class Position>
  ReachOutput run(ReachController& c, double seconds, Position&& position) {
    const int64_t end = now_ + static_cast<int64_t>(seconds * 1e6);
    ReachOutput last;
    if (!c.next_tick()) c.restart_grid(now_);
    for (int64_t frame = now_; frame < end; frame += kFrame) {
      const std::optional<Eigen::Vector3d> p = position(static_cast<double>(frame - now_) * 1e-6);
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

TEST_F(Reaching, WaitsWhileTheBridgeDoesAndTakesTheSameWayAtHalfTheRate) {
  // At half the rate, two ticks integrate as many steps as one tick at the full rate.
  ReachOptions options;
  options.ticks = TickTimes::kPeriodic;
  ReachController whole = controller(options), half = controller(options);
  for (ReachController* c : {&whole, &half}) {
    c->restart_grid(now_);
    ASSERT_TRUE(c->observe({.utime = now_, .seen = true, .position = front_}));
  }
  half.set_rate(0);
  for (int k = 0; k < 3; ++k) {
    const ReachOutput out = half.tick();
    EXPECT_EQ(out.theta, start_);
    EXPECT_EQ(out.velocity.norm(), 0);
  }
  half.set_rate(0.5);
  half.set_rate(7);  // no rate: ignored
  int64_t frame = now_;
  for (int k = 0; k < 10; ++k) {
    frame += kFrame;
    for (ReachController* c : {&whole, &half})
      ASSERT_TRUE(c->observe({.utime = frame, .seen = true, .position = front_}));
    const ReachOutput one = whole.tick();
    half.tick();
    const ReachOutput two = half.tick();
    EXPECT_LT((one.theta - two.theta).norm(), 1e-9) << "tick " << k;
  }
}

TEST_F(Reaching, FollowsAMovingTarget) {
  ReachController c = controller();
  run(c, 2, [&](double) { return front_; });
  const ReachOutput out = run(c, 3, [&](double t) { return Eigen::Vector3d(front_ + (side_ - front_) * t / 3); });
  EXPECT_EQ(out.mode, ReachMode::kReaching);
  EXPECT_LT((out.x - side_).norm(), 0.02) << "without a velocity it lags behind by the attractor's delay";
  EXPECT_LT((run(c, 2, [&](double) { return side_; }).x - side_).norm(), 1e-3);
}

TEST_F(Reaching, DoesNotLagBehindATargetWhoseVelocityIsKnown) {
  ReachController c = controller();
  run(c, 2, [&](double) { return front_; });
  const Eigen::Vector3d velocity = (side_ - front_) / 3;
  ReachOutput out;
  for (int frame = 0; frame < 75; ++frame) {
    const int64_t t = now_ + frame * kFrame;
    c.observe(
        {.utime = t, .seen = true, .position = front_ + velocity * (frame * kFrame * 1e-6), .velocity = velocity});
    while (*c.next_tick() <= t) out = c.tick();
  }
  const double elapsed = static_cast<double>(out.utime - now_) * 1e-6 + 0.05;  // the set-point is for the tick's end
  EXPECT_LT((out.x - (front_ + velocity * elapsed)).norm(), 1e-3);
}

TEST_F(Reaching, ANoisyTargetMovesTheHandLittle) {
  const CounterRandom random(7);
  for (const bool says_so : {true, false}) {
    ReachController c = controller();
    run(c, 3, [&](double) { return front_; });
    uint64_t counter = 0;
    double path = 0;
    Eigen::Vector3d x = front_;
    for (int frame = 0; frame < 300; ++frame) {
      const int64_t t = now_ + frame * kFrame;
      TargetObservation seen{.utime = t, .seen = true, .position = front_};
      for (int k = 0; k < 3; ++k) {
        seen.position[k] += 0.004 * (random.uniform(counter, -1, 1) + random.uniform(counter + 1, -1, 1));
        counter += 2;
      }
      if (says_so) seen.covariance = Eigen::Matrix3d::Identity() * 2 * 0.004 * 0.004 / 3;
      c.observe(seen);
      while (*c.next_tick() <= t) {
        const ReachOutput out = c.tick();
        if (frame > 30) path += (out.x - x).norm();
        x = out.x;
        EXPECT_LT((x - front_).norm(), 0.01);
      }
    }
    now_ += 300 * kFrame;
    previous_.resize(0);
    RecordProperty(says_so ? "path_with_covariance_m" : "path_without_m", std::to_string(path));
    EXPECT_LT(path, says_so ? 0.25 : 0.5) << "m in 9 s";
  }
}

TEST_F(Reaching, TakesUpAPushWithoutAJumpWhenThePostureIsMeasured) {
  ReachOptions options;
  options.feedback = Feedback::kMeasured;
  ReachController c = controller(options);
  run(c, 3, [&](double) { return front_; });
  ReachOutput out = c.tick();
  const JointVector reached = out.theta;
  JointVector push(4);
  push << 0.3, 0, 0, -0.2;
  const JointVector pushed = reached + push;
  JointVector before = out.theta;
  for (int k = 0; k < 20; ++k) {
    c.observe({.utime = *c.next_tick(), .seen = true, .position = front_});
    EXPECT_TRUE(c.observe_robot(pushed));
    out = c.tick();
    EXPECT_LT((out.theta - before).cwiseAbs().maxCoeff(), 0.12) << "the command never jumps";
    before = out.theta;
  }
  EXPECT_GT(out.theta[0], reached[0] + 0.1);
  EXPECT_LT(out.theta[3], reached[3] - 0.05);
  for (int k = 0; k < 80; ++k) {  // after the push, the robot follows its commands again
    c.observe({.utime = *c.next_tick(), .seen = true, .position = front_});
    c.observe_robot(out.theta);
    out = c.tick();
  }
  EXPECT_LT((out.x - front_).norm(), 1e-3) << "and the hand goes back to the target";
  JointVector bad = JointVector::Constant(4, NAN);
  EXPECT_FALSE(c.observe_robot(bad));
}

TEST_F(Reaching, ChoosesAPostureAnewWhenTheTargetJumps) {
  ReachController c = controller();
  const int64_t before = run(c, 2, [&](double) { return front_; }).ik_searches;
  const ReachOutput out = run(c, 2.5, [&](double) { return side_; });
  EXPECT_EQ(out.ik_searches, before + 1);
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
  options.on_target_lost = OnTargetLost::kGoToRest;
  options.rest = JointVector(4);
  options.rest << 0.1, -0.5, -0.1, -0.5;
  ReachController c = controller(options);
  run(c, 2, [&](double) { return front_; });
  const ReachOutput out = run(c, 4, [](double) { return std::nullopt; });
  EXPECT_EQ(out.mode, ReachMode::kResting);
  EXPECT_LT((out.theta - options.rest).norm(), 1e-3);
  EXPECT_LT((run(c, 3, [&](double) { return front_; }).x - front_).norm(), 1e-3);
}

TEST_F(Reaching, StaysWhereItIsWhenItIsLostAndToldSo) {
  ReachOptions options;
  options.on_target_lost = OnTargetLost::kStop;
  ReachController c = controller(options);
  const ReachOutput moving = run(c, 0.4, [&](double) { return front_; });
  const ReachOutput out = run(c, 3, [](double) { return std::nullopt; });
  EXPECT_EQ(out.mode, ReachMode::kHolding);
  EXPECT_LT(out.velocity.norm(), 1e-3);
  EXPECT_GT((out.x - front_).norm(), 0.01) << "it did not go on";
  EXPECT_LT((out.x - moving.x).norm(), 0.15) << "and did not go far";
  EXPECT_LT((run(c, 3, [&](double) { return front_; }).x - front_).norm(), 1e-3);
}

TEST_F(Reaching, GoesToTheNearestPointWhenTheTargetIsOutOfReach) {
  // The arm can stretch straight forward from the shoulder, so the nearest point is on the sphere of its reach.
  const Eigen::Vector3d shoulder = chain_.fixed(0).translation();
  for (const double far : {0.25, 0.4, 3.0, 1e9}) {
    const Eigen::Vector3d target = shoulder + far * Eigen::Vector3d(1, 0, 0);
    const Eigen::Vector3d nearest = shoulder + chain_.reach() * Eigen::Vector3d(1, 0, 0);
    ReachController c = controller();
    run(c, 2, [&](double) { return front_; });
    const ReachOutput out = run(c, 4, [&](double) { return Eigen::Vector3d(target); });
    EXPECT_EQ(out.mode, ReachMode::kReaching);
    EXPECT_TRUE(out.target_unreachable);
    EXPECT_LT(out.velocity.norm(), 1e-3) << "calm";
    EXPECT_LT((out.x - nearest).norm(), 1e-3) << far;
    EXPECT_EQ(chain_.limit_excess(out.theta), 0);
    const ReachOutput back = run(c, 3, [&](double) { return front_; });
    EXPECT_LT((back.x - front_).norm(), 1e-3) << "and comes back";
    EXPECT_FALSE(back.target_unreachable);
    previous_.resize(0);
  }
}

TEST_F(Reaching, FollowsATargetOutOfReachAndBack) {
  ReachController c = controller();
  run(c, 2, [&](double) { return front_; });
  const ReachOutput out =
      run(c, 3, [&](double t) { return Eigen::Vector3d(front_ + (far_ - front_) * std::min(t, 1.0)); });
  EXPECT_TRUE(out.target_unreachable);
  EXPECT_LT(out.velocity.norm(), 1e-2) << "calm";
  const ReachOutput back =
      run(c, 4, [&](double t) { return Eigen::Vector3d(far_ + (front_ - far_) * std::min(t, 1.0)); });
  EXPECT_FALSE(back.target_unreachable);
  EXPECT_LT((back.x - front_).norm(), 1e-3);
}

TEST_F(Reaching, GoesOnWhenItsClockGoesBackWhileNothingIsSeen) {
  for (const OnTargetLost without : {OnTargetLost::kHoldLastTarget, OnTargetLost::kGoToRest}) {
    ReachOptions options;
    options.on_target_lost = without;
    ReachController c = controller(options);
    c.restart_grid(now_);
    c.observe({.utime = now_, .seen = true, .position = front_, .velocity = {0.05, 0, 0}});
    c.tick();
    EXPECT_TRUE(c.restart_grid(now_ - 5000000));
    ReachOutput out;
    for (int k = 0; k < 200; ++k) {
      c.observe({.utime = *c.next_tick(), .seen = false});
      out = c.tick();
    }
    if (without == OnTargetLost::kGoToRest) {
      EXPECT_LT((out.theta - start_).norm(), 1e-4);
    } else {
      EXPECT_LT((out.x - front_).norm(), 1e-3);
    }
    EXPECT_LT(out.velocity.norm(), 1e-3) << "at rest";
  }
}

TEST_F(Reaching, RefusesTimesThatCannotBe) {
  ReachController c = controller();
  EXPECT_FALSE(c.restart_grid(INT64_MAX));
  EXPECT_FALSE(c.next_tick());
  EXPECT_FALSE(c.observe({.utime = INT64_MIN, .seen = true, .position = front_}));
}

TEST_F(Reaching, ALastingOffsetOfTheArmIsNotAPush) {
  ReachOptions options;
  options.feedback = Feedback::kMeasured;
  ReachController c = controller(options);
  c.restart_grid(now_);
  JointVector measured = start_;
  ReachOutput out;
  for (int k = 0; k < 20 * 90; ++k) {
    c.observe({.utime = *c.next_tick(), .seen = true, .position = front_});
    c.observe_robot(measured);
    out = c.tick();
    measured = out.theta;
    measured[0] += 0.1;  // calibration error of a joint
  }
  EXPECT_LT((out.x - front_).norm(), 1e-4) << "of the hand as commanded";
  EXPECT_LT(out.velocity.norm(), 1e-3);
}

TEST_F(Reaching, UnderThePaperLawATargetOutOfReachIsNotPursued) {
  ReachOptions options;
  options.law = PaperParameters{};
  for (const bool jumps : {true, false}) {
    ReachController c = controller(options);
    run(c, 2, [&](double) { return front_; });
    const ReachOutput out = run(
        c, 3, [&](double t) { return jumps ? far_ : Eigen::Vector3d(front_ + (far_ - front_) * std::min(t, 1.0)); });
    EXPECT_EQ(out.mode, ReachMode::kHolding);
    EXPECT_TRUE(out.target_unreachable);
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
  options.law = PaperParameters{.gains = {}, .gamma = -1};
  EXPECT_THROW(ReachController(chain_, options), std::invalid_argument);
  GuardedParameters overshooting;
  overshooting.gains = {0.08, 0.03};
  options.law = overshooting;
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
    const Eigen::Vector3d p = (k / 20) % 2 ? front_ : side_;  // the target jumps, so that the search also runs
    c.observe({.utime = *c.next_tick(), .seen = true, .position = p});
    c.tick();
  }
  EXPECT_EQ(testing::allocations().number, before);
  operator delete(operator new(8));
  EXPECT_EQ(testing::allocations().number, before + 1) << "the count can fail";
}

/// A steady acceleration a of the target leaves the error a / (alpha beta) steps² of a second-order attractor with
/// velocity feed-forward; the target is extrapolated by its velocity over at most a frame and a tick.
TEST_F(Reaching, TheErrorBehindATargetOnACircleIsThatOfItsAcceleration) {
  constexpr double kRadius = 0.03, kRate = M_PI, kSteps = 140;
  constexpr double kAcceleration = kRate * kRate * kRadius, kAge = 0.033 + 0.050;
  for (const ViteGains& gains : {ViteGains{0.08, 0.02}, ViteGains{0.4, 0.08}}) {
    ReachController c = controller({.law = GuardedParameters{.gains = gains}});
    c.restart_grid(now_);
    const auto position = [&](double t) {
      return (front_ + kRadius * Eigen::Vector3d(0, std::cos(kRate * t), std::sin(kRate * t))).eval();
    };
    const auto seconds = [begin = now_](int64_t utime) { return static_cast<double>(utime - begin) * 1e-6; };
    double squares = 0;
    int ticks = 0;
    for (int64_t frame = now_; seconds(frame) < 8; frame += kFrame) {
      const double t = seconds(frame);
      const Eigen::Vector3d velocity = kRadius * kRate * Eigen::Vector3d(0, -std::sin(kRate * t), std::cos(kRate * t));
      ASSERT_TRUE(c.observe({.utime = frame, .seen = true, .position = position(t), .velocity = velocity}));
      while (*c.next_tick() <= frame) {
        const ReachOutput out = c.tick();
        if (seconds(out.utime) < 4) continue;  // after the first reach
        squares += (out.x - position(seconds(out.utime) + 0.05)).squaredNorm();
        ++ticks;
      }
    }
    const double rms = std::sqrt(squares / ticks),
                 steady = kAcceleration / (gains.alpha * gains.beta * kSteps * kSteps);
    std::cout << "gains " << gains.alpha << "/" << gains.beta << ": " << 1000 * rms << " mm rms\n";
    EXPECT_LT(rms, steady + 0.5 * kAcceleration * kAge * kAge + kRadius * kRate / kSteps);
    now_ += 10000000;
  }
}

TEST_F(Reaching, AnArmThatStandsShortOfItsTargetIsBlockedAndSaysWhy) {
  ReachController c = controller({.law = GuardedParameters{.body = {.link_radius_m = 0.02}}});
  const auto ball = [](const Eigen::Vector3d& at, double radius) {
    Obstacle obstacle;
    obstacle.X_WO.translation() = at;
    obstacle.size.setConstant(radius);
    return obstacle;
  };
  ReachOutput out = run(c, 5, [&](double) { return front_; });
  EXPECT_EQ(out.blocked, Blocked::kNo);
  EXPECT_LT(out.distance_m, 1e-3);
  const Obstacle here = ball(front_, 0.04);
  c.set_obstacles({&here, 1});
  out = run(c, 10, [&](double) { return front_; });
  EXPECT_EQ(out.blocked, Blocked::kTargetInObstacle);
  EXPECT_NEAR(out.distance_m, 0.04 + 0.02 + 0.005, 3e-3) << "the ball, the link, the margin";
  c.set_obstacles({});
  out = run(c, 5, [&](double) { return front_; });
  EXPECT_EQ(out.blocked, Blocked::kNo);
  c.set_rate(0);
  out = run(c, 3, [&](double) { return side_; });
  EXPECT_EQ(out.blocked, Blocked::kNo) << "the bridge holds the robot";
}

TEST_F(Reaching, FollowsTheOrientationOfATargetThatHasOne) {
  const auto arms = testing::pose_arms();
  const auto& [name, chain] = *arms.begin();
  const CounterRandom random(3, 0);
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  ReachOptions options;
  options.task = TaskKind::kPose;
  options.orientation_frame = OrientationFrame::kTarget;
  options.orientation = turned;
  ReachController c(chain, options);
  ASSERT_TRUE(c.start(testing::random_posture(chain, random, 0, 0.2)));
  c.restart_grid(now_);
  EXPECT_FALSE(c.observe({.utime = now_, .seen = true, .position = front_})) << "it has no orientation";
  JointVector theta;
  for (uint64_t k = 1; k < 4; ++k) {
    const Eigen::Isometry3d goal = chain.pose(testing::random_posture(chain, random, k, 0.2));
    for (int64_t tick = 0; tick < 400; ++tick) {
      ASSERT_TRUE(c.observe({.utime = now_,
                             .seen = true,
                             .position = goal.translation(),
                             .orientation = goal.linear() * turned.transpose()}));
      theta = c.tick().theta;
      now_ = *c.next_tick();
    }
    const Eigen::Isometry3d hand = chain.pose(theta);
    EXPECT_LT((hand.translation() - goal.translation()).norm(), 1e-3) << name << " " << k;
    EXPECT_LT(Eigen::AngleAxisd(hand.linear().transpose() * goal.linear()).angle(), 0.01) << name << " " << k;
  }
}

}  // namespace
}  // namespace multireach::controller
