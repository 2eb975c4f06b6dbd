// Searches for IK solutions in slices: the same result as in one call, and what the law does meanwhile.
#include <gtest/gtest.h>

#include "controller/ik/multi_start.hpp"
#include "controller/law/guarded_law.hpp"
#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 83;

TaskTarget target_at(const Chain& chain, const JointVector& theta, TaskKind task) {
  const Eigen::Isometry3d X = chain.pose(theta);
  return {.position = X.translation(), .task = task, .direction = X.linear().col(2), .orientation = X.linear()};
}

std::vector<testing::NamedArm> arms() {
  std::vector<testing::NamedArm> arms = testing::pose_arms();
  arms.push_back({"Hoap2", testing::hoap2()});
  for (const int joints : {5, 9}) arms.push_back({"odd arm", testing::odd_arm(joints, kSeed)});
  return arms;
}

TEST(SearchInSlices, FindsWhatOneCallFinds) {
  for (const testing::NamedArm& arm : arms()) {
    const Chain& chain = arm.chain;
    const CounterRandom random(kSeed);
    JointVector weights = JointVector::Ones(chain.size());
    weights[0] = 7;  // heavy: moved only when no solution is found without it
    weights[1] = INFINITY;
    for (const JointVector& some_weights : {JointVector{}, weights}) {
      const MultiStartIk search(chain, {.joint_weights = some_weights});
      for (uint64_t k = 0; k < 6; ++k) {
        const TaskKind task = k % 3 == 2 && chain.size() >= 6 ? TaskKind::kPose : TaskKind::kPosition;
        TaskTarget target = target_at(chain, testing::random_posture(chain, random, 2 * k), task);
        if (k == 4) target.position *= 1.7;  // often out of reach
        const JointVector theta = testing::random_posture(chain, random, 2 * k + 1);
        const IkSolution whole = search.best(target, theta);
        for (const int work : {1, 5, 24}) {
          IkSearch slices;
          search.begin(target, theta, slices);
          while (!search.continue_search(slices, work)) continue;
          EXPECT_EQ(slices.best.theta, whole.theta) << arm.name << ", seed " << kSeed << ", case " << k;
          EXPECT_EQ(slices.best.error_m, whole.error_m);
        }
      }
    }
  }
}

TEST(SearchInSlices, AnInterruptedDescentTakesTheSameStepsAndNoMoreThanAllowed) {
  for (const testing::NamedArm& arm : testing::pose_arms()) {
    const LevenbergMarquardtIk solver(arm.chain, {});
    const CounterRandom random(kSeed);
    for (uint64_t k = 0; k < 10; ++k) {
      const TaskTarget target =
          target_at(arm.chain, testing::random_posture(arm.chain, random, 2 * k), TaskKind::kPose);
      JointVector whole = testing::random_posture(arm.chain, random, 2 * k + 1);
      IkDescent descent{whole};
      const double error = solver.solve(target, whole, 1e-7);
      while (!descent.finished) {
        const int before = descent.steps;
        EXPECT_LE(solver.descend(target, descent, 1e-7, 4), 5);
        EXPECT_LE(descent.steps - before, 4);
      }
      EXPECT_EQ(descent.posture, whole) << arm.name << ", seed " << kSeed << ", case " << k;
      EXPECT_EQ(descent.error, error);
    }
  }
}

// Far from the target, so that theta_T gets stuck in a local minimum now and then and another one must be searched.
TEST(SearchInSlices, TheLawGoesOnMeanwhileAndArrives) {
  const Chain chain = testing::six_joint_arm().chain;
  const CounterRandom random(kSeed);
  int64_t searches = 0, steps_searching = 0;
  for (uint64_t k = 0; k < 40; ++k) {
    GuardedLaw law(chain);
    ASSERT_TRUE(law.start(testing::random_posture(chain, random, 3 * k)));
    const TaskTarget target = target_at(chain, testing::random_posture(chain, random, 3 * k + 1), TaskKind::kPose);
    ASSERT_EQ(law.set_target(target, testing::random_posture(chain, random, 3 * k + 2)), TargetResult::kReachable);
    for (int step = 0; step < 20 * 140; ++step) {
      const JointVector before = law.theta_target();
      const bool searching = law.searching();
      law.step();
      if (searching && law.searching()) {
        EXPECT_LE((law.theta_target() - before).cwiseAbs().maxCoeff(), 0.05 + 1e-12);
        ++steps_searching;
      }
      if (!law.searching()) continue;
      EXPECT_LE(chain.limit_excess(law.theta()), 1e-9);
    }
    EXPECT_LT((law.x() - target.position).norm(), 1e-4) << "seed " << kSeed << ", case " << k;
    searches += law.ik_searches();
  }
  EXPECT_GT(searches, 5);
  EXPECT_GT(steps_searching, 5 * searches);  // a search takes many steps
}

TEST(SearchInSlices, ANewGoalEndsASearch) {
  const Chain chain = testing::six_joint_arm().chain;
  const CounterRandom random(kSeed);
  int ended = 0;
  for (uint64_t k = 0; k < 40 && ended < 6; ++k) {
    GuardedLaw law(chain);
    ASSERT_TRUE(law.start(testing::random_posture(chain, random, 3 * k)));
    const TaskTarget target = target_at(chain, testing::random_posture(chain, random, 3 * k + 1), TaskKind::kPose);
    law.set_target(target, testing::random_posture(chain, random, 3 * k + 2));
    for (int step = 0; step < 1000 && !law.searching(); ++step) law.step();
    if (!law.searching()) continue;
    const JointVector goal = testing::random_posture(chain, random, 3 * k + 2);
    if (ended++ % 2 == 0) {
      ASSERT_TRUE(law.set_joint_target(goal));
    } else {
      ASSERT_TRUE(law.start(goal));
    }
    EXPECT_FALSE(law.searching());
    for (int step = 0; step < 20 * 140; ++step) law.step();
    EXPECT_LT((JointVector(law.theta()) - goal).norm(), 1e-3) << "seed " << kSeed << ", case " << k;
  }
  EXPECT_EQ(ended, 6);
}

}  // namespace
}  // namespace multireach::controller
