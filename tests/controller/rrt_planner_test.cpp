#include "controller/collision/rrt_planner.hpp"

#include <gtest/gtest.h>

#include "controller/law/guarded_law.hpp"
#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 61;
constexpr double kStepsPerSecond = 140;

using Configurations = std::vector<Eigen::VectorXd>;

Configurations configurations(const RrtPlanner& planner) {
  return {planner.path().begin(), planner.path().end()};
}

/// An arm, a ball between two of its configurations, and these.
struct Problem {
  Chain chain;
  Body body;
  Eigen::VectorXd start, goal;
  Obstacle ball;
  Proximity proximity;

  Problem(const Chain& arm, uint64_t k)
      : chain(arm), body{.link_radius_m = 0.05 * arm.reach(), .self_collision = false}, proximity(arm, body) {
    const CounterRandom random(kSeed, k);
    for (uint64_t attempt = 0;; attempt += 2) {
      start = testing::random_posture(chain, random, attempt);
      goal = testing::random_posture(chain, random, attempt + 1);
      ball.X_WO.translation() = chain.position(0.5 * (start + goal));
      ball.size.setConstant(0.15 * chain.reach());
      proximity.set_obstacles({&ball, 1});
      if (proximity.clearance(start) > 0 && proximity.clearance(goal) > 0) return;
    }
  }

  /// The path, planned by parts of so much work, and how many parts it took.
  std::pair<Configurations, int> plan(int work, uint64_t seed = 1) {
    RrtPlanner planner(chain);
    planner.begin(start, goal, proximity, seed);
    int parts = 1;
    while (!planner.continue_planning(proximity, work)) ++parts;
    return {configurations(planner), parts};
  }
};

std::vector<testing::NamedArm> arms() {
  return {{"Hoap2", testing::hoap2()}, testing::seven_joint_arm()};
}

TEST(RrtPlanner, ItsPathLeadsToTheGoalAndKeepsClear) {
  for (const auto& [name, chain] : arms()) {
    int planned = 0;
    for (uint64_t k = 0; k < 20; ++k) {
      SCOPED_TRACE(name + ", problem " + std::to_string(k));
      Problem problem(chain, k);
      const auto path = problem.plan(RrtPlanner::kAllWork).first;
      if (path.empty()) continue;
      ++planned;
      EXPECT_EQ(path.back(), problem.goal);
      Eigen::VectorXd from = problem.start;
      for (const Eigen::VectorXd& to : path) {
        // Clearances are computed every 0.05 rad. Between, no point of the arm moves by more than half of that, times
        // the reach, for each joint.
        const double most = 0.025 * problem.chain.reach() * std::sqrt(problem.chain.size());
        for (int i = 0; i <= 100; ++i)
          EXPECT_GT(problem.proximity.clearance(from + (to - from) * (i / 100.0)), -1e-6 - most);
        from = to;
      }
    }
    EXPECT_GE(planned, 15) << name;
  }
}

TEST(RrtPlanner, PartsOfTheWorkGiveTheSamePath) {
  for (const auto& [name, chain] : arms()) {
    for (uint64_t k = 0; k < 10; ++k) {
      SCOPED_TRACE(name + ", problem " + std::to_string(k));
      Problem problem(chain, k);
      const auto whole = problem.plan(RrtPlanner::kAllWork);
      EXPECT_EQ(whole.second, 1);
      const auto ones = problem.plan(1);
      EXPECT_EQ(ones.first, whole.first) << "to the bit";
      for (const int work : {3, 8, 100}) {
        const auto [path, parts] = problem.plan(work);
        EXPECT_EQ(path, whole.first) << "to the bit";
        // With one unit, every part but the last computes a clearance or adds a node. Each of these takes a unit or
        // more, so that a part of `work` has at most so many, and the node that follows the last clearance.
        EXPECT_GE(parts * (work + 2), ones.second - 1) << "parts of " << work;
      }
    }
  }
}

TEST(RrtPlanner, ACopyContinuesThePlan) {
  Problem problem(testing::hoap2(), 3);
  const auto whole = problem.plan(RrtPlanner::kAllWork).first;
  ASSERT_FALSE(whole.empty());
  RrtPlanner planner(problem.chain);
  planner.begin(problem.start, problem.goal, problem.proximity, 1);
  ASSERT_FALSE(planner.continue_planning(problem.proximity, 5));
  RrtPlanner copy = planner;
  EXPECT_TRUE(copy.continue_planning(problem.proximity, RrtPlanner::kAllWork));
  EXPECT_EQ(configurations(copy), whole);
  EXPECT_TRUE(planner.path().empty()) << "the first one is where it was";
}

/// The Hoap2 before a wall, behind which its target is.
struct BeforeAWall {
  Chain chain = testing::hoap2();
  Obstacle box{.shape = Obstacle::Shape::kBox, .size = {0.10, 0.01, 0.06}};
  JointVector there{4};
  GuardedLaw law;

  explicit BeforeAWall(double steps_per_second = kStepsPerSecond)
      : law(chain, {.steps_per_second = steps_per_second, .body = {.link_radius_m = 0.02}}) {
    JointVector start(4);
    start << -0.9, -0.1, 0.3, -1.2;
    there << -0.9, -1.1, -0.3, -1.1;
    box.X_WO.translation() = 0.5 * (chain.position(start) + chain.position(there));
    law.set_obstacles({&box, 1});
    law.start(start);
    law.set_target({.position = chain.position(there)}, there);
  }
  /// Steps until a plan has begun; false when none begins within 10 s.
  bool until_it_plans(double steps_per_second = kStepsPerSecond) {
    for (int k = 0; k < 10 * steps_per_second && !law.planning(); ++k) law.step();
    return law.planning();
  }
};

TEST(PlanAroundAnObstruction, TakesSeveralStepsAndACopyDoesAlike) {
  BeforeAWall scene;
  GuardedLaw& law = scene.law;
  ASSERT_TRUE(scene.until_it_plans());
  law.step();
  GuardedLaw copy = law;
  int planned = 1;
  for (; law.planning() && planned < 1400; ++planned) {
    EXPECT_FALSE(law.following_path());
    law.step();
    copy.step();
  }
  EXPECT_GT(planned, 2);
  EXPECT_TRUE(law.following_path());
  for (int k = 0; k < 700; ++k) {
    law.step();
    copy.step();
  }
  EXPECT_EQ(copy.theta(), law.theta()) << "to the bit";
  EXPECT_LT((law.x() - scene.chain.position(scene.there)).norm(), 1e-4);
}

TEST(PlanAroundAnObstruction, EndsAtAnyRate) {
  for (const double rate : {100.0, 1400.0, 5000.0}) {
    BeforeAWall scene(rate);
    ASSERT_TRUE(scene.until_it_plans(rate)) << rate;
    for (int k = 0; k < 5 * rate && !scene.law.following_path(); ++k) scene.law.step();
    EXPECT_TRUE(scene.law.following_path()) << rate;
  }
}

TEST(PlanAroundAnObstruction, IsDroppedWhenTheTargetOrTheObstaclesChange) {
  const auto dropped = [](const auto& change) {
    BeforeAWall scene;
    EXPECT_TRUE(scene.until_it_plans());
    change(scene);
    scene.law.step();
    EXPECT_FALSE(scene.law.following_path());
    return !scene.law.planning();
  };
  const auto target = [](const BeforeAWall& scene, double share) {
    const Eigen::Vector3d hand = scene.law.x();
    return TaskTarget{.position = hand + share * (scene.chain.position(scene.there) - hand)};
  };
  EXPECT_TRUE(dropped([&](BeforeAWall& scene) { scene.law.update_target(target(scene, 0.2)); }));
  EXPECT_FALSE(dropped([&](BeforeAWall& scene) { scene.law.update_target(target(scene, 0.99)); }));
  EXPECT_TRUE(dropped([&](BeforeAWall& scene) { scene.law.set_target(target(scene, 1)); }));
  EXPECT_TRUE(dropped([&](BeforeAWall& scene) { scene.law.set_joint_target(scene.there); }));
  EXPECT_TRUE(dropped([](BeforeAWall& scene) { scene.law.set_obstacles({}); }));
  EXPECT_TRUE(dropped([](BeforeAWall& scene) {
    scene.box.size.z() = 0.07;
    scene.law.set_obstacles({&scene.box, 1});
  }));
  EXPECT_FALSE(dropped([](BeforeAWall& scene) { scene.law.set_obstacles({&scene.box, 1}); }));
  EXPECT_FALSE(dropped([](BeforeAWall&) {}));
}

TEST(PlanAroundAnObstruction, TheSameObstaclesAgainEndNoPath) {
  BeforeAWall scene;
  ASSERT_TRUE(scene.until_it_plans());
  for (int k = 0; k < 1400 && !scene.law.following_path(); ++k) scene.law.step();
  ASSERT_TRUE(scene.law.following_path());
  EXPECT_EQ(scene.law.set_obstacles({&scene.box, 1}), 0);
  EXPECT_TRUE(scene.law.following_path());
  EXPECT_EQ(scene.law.set_obstacles({}), 0);
  EXPECT_FALSE(scene.law.following_path());
}

}  // namespace
}  // namespace multireach::controller
