// Calls in the wrong order, orientations that are almost rotations, targets that are not refreshed or flicker.
#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "controller/law/supervised_paper_law.hpp"
#include "controller/reach_controller.hpp"
#include "controller/task/target_check.hpp"
#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 17;

TEST(WrongInput, NothingMovesBeforeTheLawKnowsWhereTheArmIs) {
  const Chain chain = testing::hoap2();
  GuardedLaw guarded(chain);
  SupervisedPaperLaw paper(chain, {}, 0.01, {});
  const JointVector there = JointVector::Constant(4, -0.3);
  const TaskTarget target{.position = chain.position(there)};
  for (ReachingLaw* law : {static_cast<ReachingLaw*>(&guarded), static_cast<ReachingLaw*>(&paper)}) {
    const JointVector before = law->theta();
    EXPECT_EQ(law->set_target(target), TargetResult::kNotStarted);
    EXPECT_EQ(law->update_target(target), TargetResult::kNotStarted);
    EXPECT_FALSE(law->set_joint_target(there));
    for (int k = 0; k < 100; ++k) law->step();
    EXPECT_EQ(law->theta(), before);
    EXPECT_FALSE(law->start(JointVector::Zero(3))) << "a refused start is none";
    EXPECT_EQ(law->set_target(target), TargetResult::kNotStarted);
    EXPECT_TRUE(law->start(JointVector::Zero(4)));
    EXPECT_EQ(law->set_target(target), TargetResult::kReachable);
    for (int k = 0; k < 100; ++k) law->step();
    EXPECT_NE(law->theta(), before);
  }
  EXPECT_EQ(guarded.set_target(target, there), TargetResult::kReachable);
  EXPECT_EQ(GuardedLaw(chain).set_target(target, there), TargetResult::kNotStarted);
}

TEST(WrongInput, ATickBeforeTheStartHasNoJointPositions) {
  const Chain chain = testing::hoap2();
  ReachController c(chain, {});
  EXPECT_EQ(c.tick().mode, ReachMode::kNotStarted) << "neither started nor a grid";
  c.restart_grid(1000000);
  c.observe({.utime = 1000000, .seen = true, .position = {0.1, -0.12, 0.1}});
  const ReachOutput early = c.tick();
  EXPECT_EQ(early.mode, ReachMode::kNotStarted);
  EXPECT_EQ(early.theta.size(), 0);
  EXPECT_EQ(*c.next_tick(), 1000000) << "it was no tick";
  c.start(JointVector::Constant(4, -0.3));
  EXPECT_EQ(c.tick().mode, ReachMode::kWaiting) << "for a target that is seen after the start";
}

TEST(WrongInput, AlmostARotationIsCorrectedAndOthersAreRefusedWithAReason) {
  const CounterRandom random(kSeed);
  uint64_t counter = 0;
  for (int k = 0; k < 200; ++k) {
    Eigen::Matrix3d R = Eigen::Quaterniond(random.uniform(counter, -1, 1), random.uniform(counter + 1, -1, 1),
                                           random.uniform(counter + 2, -1, 1), random.uniform(counter + 3, -1, 1))
                            .normalized()
                            .toRotationMatrix();
    counter += 4;
    EXPECT_EQ(nearest_rotation(R), R) << "left as it is";
    for (double& element : R.reshaped()) element += random.uniform(counter++, -1e-4, 1e-4);
    const auto corrected = nearest_rotation(R);
    ASSERT_TRUE(corrected) << "seed " << kSeed << ", case " << k;
    // The nearest rotation is U V^T of the singular value decomposition.
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
    EXPECT_TRUE(corrected->isApprox(svd.matrixU() * svd.matrixV().transpose(), 1e-14));
  }
  const auto fault = [](const TaskTarget& target) {
    EXPECT_EQ(target_fault(target) == nullptr, checked_target(target).has_value());
    return std::string(target_fault(target) ? target_fault(target) : "");
  };
  TaskTarget target{.task = TaskKind::kPose};
  EXPECT_EQ(fault(target), "");
  target.orientation(0, 1) += 0.01;
  EXPECT_NE(fault(target).find("not a rotation matrix"), std::string::npos);
  target.orientation = -Eigen::Matrix3d::Identity();
  EXPECT_NE(fault(target).find("determinant 1"), std::string::npos) << "a mirror";
  target.orientation(0, 0) = NAN;
  EXPECT_NE(fault(target), "");
  EXPECT_EQ(fault({.direction = {0, 0, 2}}), "") << "a position needs no direction";
  EXPECT_EQ(fault({.task = TaskKind::kPointing, .direction = {0, 0, 1.0005}}), "");
  EXPECT_NE(fault({.task = TaskKind::kPointing, .direction = {0, 0, 2}}).find("unit vector"), std::string::npos);
  EXPECT_NE(fault({.position = {NAN, 0, 0}}).find("position"), std::string::npos);
  EXPECT_NE(fault({.velocity = {INFINITY, 0, 0}}).find("velocity"), std::string::npos);
  EXPECT_DOUBLE_EQ(checked_target({.task = TaskKind::kPointing, .direction = {0, 0, 1.0005}})->direction.norm(), 1);
}

TEST(WrongInput, ATargetThatIsNotRefreshedStops) {
  const Chain chain = testing::hoap2();
  const Eigen::Vector3d from(0.1, -0.2, 0.1), velocity = Eigen::Vector3d(0, 0.02, 0) / 140;
  const auto goal_after = [&](const GuardedParameters& parameters, int steps, bool refreshed) {
    GuardedLaw law(chain, parameters);
    law.start(JointVector::Constant(4, -0.3));
    law.set_target({.position = from, .velocity = velocity});
    for (int k = 0; k < steps; ++k) {
      if (refreshed && k % 70 == 0) law.update_target({.position = from + k * velocity, .velocity = velocity});
      law.step();
    }
    return law.x_target();
  };
  EXPECT_LT((goal_after({}, 700, true) - (from + 700 * velocity)).norm(), 1e-3) << "refreshed: it moves on";
  EXPECT_LT((goal_after({}, 700, false) - (from + 140 * velocity)).norm(), 1e-3) << "for one second";
  EXPECT_LT((goal_after({.extrapolation_s = 3}, 700, false) - (from + 420 * velocity)).norm(), 1e-3);
}

/// Changes of the direction of all joints, while the target is seen at 30 Hz at `position(s)` for `seconds`.
template <class Position>
int reversals(ReachController& c, double seconds, const Position& position, bool& flickered) {
  JointVector last = JointVector::Zero(4);
  int count = 0;
  constexpr int64_t kBegin = 1000000;
  c.restart_grid(kBegin);
  for (int64_t frame = kBegin; frame < kBegin + static_cast<int64_t>(seconds * 1e6); frame += 33333) {
    c.observe({.utime = frame, .seen = true, .position = position(1e-6 * static_cast<double>(frame - kBegin))});
    while (*c.next_tick() <= frame) {
      const ReachOutput out = c.tick();
      flickered = flickered || out.target_flickers;
      for (int i = 0; i < 4; ++i) {
        if (std::abs(out.velocity[i]) < 1e-3) continue;
        if (out.velocity[i] * last[i] < 0) ++count;
        last[i] = out.velocity[i];
      }
    }
  }
  return count;
}

TEST(WrongInput, ATargetThatFlickersIsFollowedOnlyWhenItStays) {
  const Chain chain = testing::hoap2();
  const Eigen::Vector3d here(0.10, -0.12, 0.10), there(0.05, -0.22, 0.10);
  ReachController c(chain, {});
  c.start((JointVector(4) << 0.2, -0.3, -0.2, -0.9).finished());
  bool flickered = false;
  const auto flickering = [&](double t) { return static_cast<int>(t / 0.1) % 2 == 0 || t > 10 ? here : there; };
  EXPECT_LT(reversals(c, 10, flickering, flickered), 20);
  EXPECT_TRUE(flickered);
  EXPECT_LT((c.tick().x - here).norm() * (c.tick().x - there).norm(), 1e-4) << "it is at one of them";
  flickered = false;
  ReachController again(chain, {});
  again.start((JointVector(4) << 0.2, -0.3, -0.2, -0.9).finished());
  reversals(again, 13, flickering, flickered);
  const ReachOutput out = again.tick();
  EXPECT_FALSE(out.target_flickers);
  EXPECT_LT((out.x - here).norm(), 1e-3) << "it stays there since 10 s";
}

TEST(WrongInput, ATargetThatJumpsTwiceASecondIsFollowed) {
  const Chain chain = testing::hoap2();
  const Eigen::Vector3d here(0.10, -0.12, 0.10), there(0.05, -0.22, 0.10);
  ReachController c(chain, {});
  c.start((JointVector(4) << 0.2, -0.3, -0.2, -0.9).finished());
  bool flickered = false;
  reversals(
      c, 6, [&](double t) { return static_cast<int>(t / 0.6) % 2 == 0 ? here : there; }, flickered);
  EXPECT_FALSE(flickered);
}

}  // namespace
}  // namespace multireach::controller
