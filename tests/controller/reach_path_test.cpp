// Short hand paths: the optimiser against its definition, the planner against plain kinematics, and the guarded law
// that follows them.
#include "controller/law/reach_path.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "controller/law/guarded_law.hpp"
#include "numeric/random.hpp"
#include "tests/allocation_count.hpp"
#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 41;

GuardedParameters with_work(int work = GuardedParameters::kUsualPathWork) {
  GuardedParameters parameters;
  parameters.path_work = work;
  return parameters;
}

JointVector posture(const Chain& chain, uint64_t reach, uint64_t which) {
  return testing::random_posture(chain, CounterRandom(kSeed, reach), which, 0);
}

/// The optimiser's objective, from its definition and the plain kinematics.
double objective(const Chain& chain, const JointPath& path, const Eigen::Vector3d& target, double gamma) {
  double sum = 300 * (target - chain.position(path.knot(JointPath::kSegments, chain.size()))).squaredNorm();
  for (size_t k = 1; k <= JointPath::kSegments; ++k) {
    const JointVector from = path.knot(k - 1, chain.size()), to = path.knot(k, chain.size());
    sum += (chain.position(to) - chain.position(from)).squaredNorm() + (to - from).squaredNorm() / gamma;
  }
  return sum;
}

double hand_length(const Chain& chain, const JointPath& path) {
  constexpr int kSamples = 50;
  double sum = 0;
  for (size_t k = 0; k < JointPath::kSegments; ++k) {
    const JointVector from = path.knot(k, chain.size()), to = path.knot(k + 1, chain.size());
    for (int s = 0; s < kSamples; ++s) {
      const JointVector one = from + static_cast<double>(s) / kSamples * (to - from);
      const JointVector other = from + static_cast<double>(s + 1) / kSamples * (to - from);
      sum += (chain.position(other) - chain.position(one)).norm();
    }
  }
  return sum;
}

TEST(PathOptimizer, FindsALocalMinimumInsideTheLimits) {
  for (const auto& file : testing::all_arm_files()) {
    const Chain chain = testing::load(file);
    const double gamma = 42.5 / (chain.reach() * chain.reach());
    PathOptimizer optimizer(chain, guarded_settings(chain, {}).mobility);
    for (uint64_t reach = 0; reach < 20; ++reach) {
      SCOPED_TRACE(file.path + ", seed " + std::to_string(kSeed) + ", reach " + std::to_string(reach));
      const Eigen::Vector3d target = chain.position(posture(chain, reach, 1));
      JointPath path;
      path.set_line(0, JointPath::kSegments, posture(chain, reach, 0), posture(chain, reach, 1));
      optimizer.begin(path, target, gamma, 0);
      const double before = objective(chain, path, target, gamma);
      for (int step = 0; step < 200 && optimizer.improve(); ++step) {
      }
      path = optimizer.path();
      const double after = objective(chain, path, target, gamma);
      EXPECT_LE(after, before * (1 + 1e-12));
      EXPECT_EQ(path.knot(0, chain.size()), posture(chain, reach, 0));
      for (size_t k = 1; k <= JointPath::kSegments; ++k) {
        const JointVector knot = path.knot(k, chain.size());
        EXPECT_LE(chain.limit_excess(knot), 0);
        for (int i = 0; i < chain.size(); ++i) {
          for (const double by : {-0.02, 0.02}) {
            JointVector moved = knot;
            moved[i] = std::clamp(moved[i] + by, chain.lower()[i], chain.upper()[i]);
            JointPath other = path;
            other.set_knot(k, moved);
            // The optimiser stops when a step gains less than a part in 10^4.
            EXPECT_GE(objective(chain, other, target, gamma), after * (1 - 1e-3)) << "knot " << k << ", joint " << i;
          }
        }
      }
    }
  }
}

TEST(PathPlanner, ItsPathEndsAtTheTargetAndIsAsLongAsItSays) {
  for (const auto& file : testing::all_arm_files()) {
    const Chain chain = testing::load(file);
    PathPlanner planner(chain, guarded_settings(chain, {}).mobility, LevenbergMarquardtIk(chain, {}));
    Proximity nothing(chain, {});
    for (uint64_t reach = 0; reach < 20; ++reach) {
      SCOPED_TRACE(file.path + ", seed " + std::to_string(kSeed) + ", reach " + std::to_string(reach));
      const JointVector start = posture(chain, reach, 0), goal = posture(chain, reach, 1);
      const Eigen::Vector3d target = chain.position(goal);
      planner.begin(start, target, goal);
      EXPECT_FALSE(planner.found());
      planner.advance(70, nothing);
      ASSERT_TRUE(planner.found());
      const JointPath& path = planner.path();
      EXPECT_EQ(path.knot(0, chain.size()), start);
      EXPECT_LT((chain.position(path.knot(JointPath::kSegments, chain.size())) - target).norm(), 1e-6);
      const double length = hand_length(chain, path);
      EXPECT_GE(length, (chain.position(start) - target).norm() * (1 - 1e-9));
      EXPECT_NEAR(planner.length_m(), length, 0.02 * length);  // 8 samples of a segment here, 50 there
      for (size_t k = 0; k <= JointPath::kSegments; ++k) {
        EXPECT_LE(chain.limit_excess(path.knot(k, chain.size())), 0);
      }
    }
  }
}

TEST(PathPlanner, DependsOnTheWorkAndNotOnItsSlices) {
  const Chain chain = testing::hoap2();
  const LevenbergMarquardtIk solver(chain, {});
  const JointVector start = posture(chain, 3, 0), goal = posture(chain, 3, 1);
  Proximity nothing(chain, {});
  PathPlanner whole(chain, guarded_settings(chain, {}).mobility, solver), sliced = whole;
  whole.begin(start, chain.position(goal), goal);
  sliced.begin(start, chain.position(goal), goal);
  whole.advance(70, nothing);
  for (int k = 0; k < 70; ++k) sliced.advance(1, nothing);
  EXPECT_EQ(whole.path().knots, sliced.path().knots);
  EXPECT_EQ(whole.length_m(), sliced.length_m());
}

TEST(PathPlanner, RejectsPathsThroughObstacles) {
  const Chain chain = testing::hoap2();
  PathPlanner planner(chain, guarded_settings(chain, {}).mobility, LevenbergMarquardtIk(chain, {}));
  Body body;
  body.link_radius_m = 0.02;
  Proximity empty(chain, body), with_sphere(chain, body);
  int rejected = 0, found = 0;
  for (uint64_t reach = 300; reach < 360; ++reach) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", reach " + std::to_string(reach));
    const JointVector start = posture(chain, reach, 0), goal = posture(chain, reach, 1);
    const auto least_clearance = [&] {
      double least = 1;
      for (size_t k = 2; k <= JointPath::kSegments; k += 2) {
        least = std::min(least, with_sphere.clearance(planner.path().knot(k, chain.size())));
      }
      return least;
    };
    empty.set_obstacles({});
    planner.begin(start, chain.position(goal), goal);
    planner.advance(200, empty);
    ASSERT_TRUE(planner.found());
    const JointVector middle = planner.path().knot(JointPath::kSegments / 2, chain.size());
    with_sphere.set_obstacles(
        std::array{Obstacle{.shape = Obstacle::Shape::kSphere,
                            .X_WO = Eigen::Isometry3d(Eigen::Translation3d(chain.position(middle))),
                            .size = Eigen::Vector3d(0.01, 0, 0)}});
    EXPECT_LT(least_clearance(), 0);
    planner.begin(start, chain.position(goal), goal);
    planner.advance(200, with_sphere);
    if (!planner.found()) {
      ++rejected;
      continue;
    }
    ++found;
    EXPECT_GE(least_clearance(), 0);
  }
  EXPECT_GT(rejected, 0);
  EXPECT_GT(found, 0);
}

struct Way {
  double ratio = 0;
  bool arrived = false, led = false;
};

/// Runs a reach and checks its limits.
Way run(GuardedLaw& law, const JointVector& start, const Eigen::Vector3d& target) {
  const Chain& chain = law.chain();
  law.start(start);
  law.set_target({.position = target});
  const double distance = (law.x() - target).norm();
  double length = 0;
  Way way;
  for (int step = 0; step < 2800; ++step) {
    const Eigen::Vector3d before = law.x();
    law.step();
    way.led = way.led || law.following_short_path();
    length += (law.x() - before).norm();
    EXPECT_LE(chain.limit_excess(law.theta()), 1e-12);
    EXPECT_LE(((law.velocity() * 140).cwiseAbs() - chain.velocity()).maxCoeff(), 1e-9);
  }
  way.ratio = length / distance;
  way.arrived = (law.x() - target).norm() < 1e-4;
  return way;
}

TEST(GuardedLaw, TakesShorterWaysWithPaths) {
  for (const auto& file : testing::all_arm_files()) {
    const Chain chain = testing::load(file);
    GuardedLaw with(chain, with_work()), without(chain);
    std::vector<double> short_ones, others;
    int led = 0;
    constexpr uint64_t kReaches = 40;
    for (uint64_t reach = 100; reach < 100 + kReaches; ++reach) {
      SCOPED_TRACE(file.path + ", seed " + std::to_string(kSeed) + ", reach " + std::to_string(reach));
      const Eigen::Vector3d target = chain.position(posture(chain, reach, 1));
      const Way way = run(with, posture(chain, reach, 0), target);
      EXPECT_TRUE(way.arrived);
      led += way.led;
      short_ones.push_back(way.ratio);
      const Way other = run(without, posture(chain, reach, 0), target);
      EXPECT_FALSE(other.led);
      others.push_back(other.ratio);
    }
    std::ranges::sort(short_ones);
    std::ranges::sort(others);
    EXPECT_GT(led, static_cast<int>(kReaches) / 2) << file.path;
    EXPECT_LT(short_ones[kReaches / 2], others[kReaches / 2]) << file.path;
    EXPECT_LT(short_ones[kReaches * 9 / 10], others[kReaches * 9 / 10]) << file.path;
    EXPECT_LT(short_ones[kReaches / 2], 1.04) << file.path;  // the aim for the median
  }
}

/// The first reach from number 100 on in which the law follows a path.
uint64_t reach_with_path(const Chain& chain) {
  GuardedLaw law(chain, with_work());
  for (uint64_t reach = 100;; ++reach) {
    law.start(posture(chain, reach, 0));
    law.set_target({.position = chain.position(posture(chain, reach, 1))});
    for (int step = 0; step <= 7; ++step) law.step();
    if (law.following_short_path()) return reach;
  }
}

/// The law after `steps` of this reach.
GuardedLaw on_its_way(const Chain& chain, uint64_t reach, int steps) {
  GuardedLaw law(chain, with_work());
  law.start(posture(chain, reach, 0));
  law.set_target({.position = chain.position(posture(chain, reach, 1))});
  for (int step = 0; step < steps; ++step) law.step();
  return law;
}

TEST(GuardedLaw, BeginsAPathAfterSevenStepsAndRestoresGammaAtItsEnd) {
  const Chain chain = testing::seven_joint_arm().chain;
  GuardedLaw law = on_its_way(chain, reach_with_path(chain), 7);
  EXPECT_FALSE(law.following_short_path());
  EXPECT_EQ(law.gamma(), law.largest_gamma());
  law.step();
  EXPECT_TRUE(law.following_short_path());
  EXPECT_EQ(law.gamma(), 0);
  for (int step = 0; step < 2800 && law.following_short_path(); ++step) law.step();
  EXPECT_FALSE(law.following_short_path());
  EXPECT_EQ(law.gamma(), law.largest_gamma());
}

TEST(GuardedLaw, ACopyInTheMiddleOfAPlanOrAPathContinuesAlike) {
  const Chain chain = testing::hoap2();
  for (const int steps : {3, 60}) {
    GuardedLaw law = on_its_way(chain, reach_with_path(chain), steps), copy = law;
    for (int step = 0; step < 400; ++step) {
      law.step();
      copy.step();
      ASSERT_EQ(law.theta(), copy.theta()) << steps << ", " << step;
    }
  }
}

TEST(GuardedLaw, GivesUpAPathWhenTheTargetMovesOrTheArmIsPushed) {
  const Chain chain = testing::seven_joint_arm().chain;
  const uint64_t reach = reach_with_path(chain);
  const Eigen::Vector3d target = chain.position(posture(chain, reach, 1));
  GuardedLaw law = on_its_way(chain, reach, 40);
  ASSERT_TRUE(law.following_short_path());
  law.update_target({.position = target + Eigen::Vector3d(0.001, 0, 0)});  // as vision's noise moves it
  law.step();
  EXPECT_TRUE(law.following_short_path());
  const Eigen::Vector3d elsewhere = target - 0.1 * (target - chain.fixed(0).translation());
  law.update_target({.position = elsewhere});
  law.step();
  EXPECT_FALSE(law.following_short_path());
  EXPECT_EQ(law.gamma(), law.largest_gamma());
  for (int step = 0; step < 2800; ++step) law.step();
  EXPECT_LT((law.x() - elsewhere).norm(), 1e-4);

  GuardedLaw pushed = on_its_way(chain, reach, 40);
  ASSERT_TRUE(pushed.following_short_path());
  pushed.compensate(JointVector::Constant(chain.size(), 0.1));
  pushed.step();
  EXPECT_FALSE(pushed.following_short_path());
  pushed.compensate(JointVector::Zero(chain.size()));
  for (int step = 0; step < 2800; ++step) pushed.step();
  EXPECT_LT((pushed.x() - target).norm(), 1e-4);
}

TEST(GuardedLaw, PlansNoPathWhereNoneIsAskedFor) {
  const Chain chain = testing::seven_joint_arm().chain;
  const uint64_t reach = reach_with_path(chain);
  const JointVector start = posture(chain, reach, 0), goal = posture(chain, reach, 1);
  const TaskTarget target{.position = chain.position(goal)};
  const auto leads = [](GuardedLaw& law) {
    bool led = false;
    for (int step = 0; step < 300; ++step) {
      law.step();
      led = led || law.following_short_path();
    }
    return led;
  };
  GuardedLaw law(chain, with_work());
  law.start(start);
  law.set_target(target);
  EXPECT_TRUE(leads(law)) << "the check can fail";
  law.start(start);
  law.set_target(target, goal);
  EXPECT_FALSE(leads(law)) << "a given theta_T";
  law.start(start);
  law.set_joint_target(goal);
  EXPECT_FALSE(leads(law)) << "a joint target";
  law.start(start);
  TaskTarget pose = target;
  pose.task = TaskKind::kPose;
  pose.orientation = chain.pose(goal).linear();
  law.set_target(pose);
  EXPECT_FALSE(leads(law)) << "a pose";
  law.start(start);
  law.set_target({.position = target.position, .velocity = Eigen::Vector3d::Constant(1e-3)});
  EXPECT_FALSE(leads(law)) << "a moving target";
  GuardedLaw without(chain);
  without.start(start);
  without.set_target(target);
  EXPECT_FALSE(leads(without)) << "by default";
  EXPECT_THROW(GuardedLaw(chain, with_work(-1)), std::invalid_argument);
}

TEST(GuardedLaw, PlansAndFollowsPathsWithoutAllocation) {
  const Chain chain = testing::hoap2();
  GuardedLaw law = on_its_way(chain, reach_with_path(chain), 0);
  const int64_t before = testing::allocations().number;
  for (int step = 0; step < 300; ++step) law.step();
  EXPECT_EQ(testing::allocations().number, before);
}

TEST(GuardedLaw, KeepsPathsOutOfObstacles) {
  const Chain chain = testing::hoap2();
  GuardedParameters parameters = with_work();
  parameters.body.link_radius_m = 0.02;
  GuardedLaw law(chain, parameters);
  int led = 0;
  for (uint64_t reach = 200; reach < 240; ++reach) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", reach " + std::to_string(reach));
    const JointVector start = posture(chain, reach, 0), goal = posture(chain, reach, 1);
    law.set_obstacles({});
    law.start(start);
    // A sphere beside the middle of the straight hand path, away from the arm at both ends.
    const Eigen::Vector3d middle = 0.5 * (chain.position(start) + chain.position(goal));
    law.set_obstacles(std::array{Obstacle{.shape = Obstacle::Shape::kSphere,
                                          .X_WO = Eigen::Isometry3d(Eigen::Translation3d(middle)),
                                          .size = Eigen::Vector3d(0.02, 0, 0)}});
    if (law.clearance() < 0.02) continue;
    law.set_target({.position = chain.position(goal)});
    double least = 1;
    for (int step = 0; step < 700; ++step) {
      law.step();
      led += law.following_short_path();
      least = std::min(least, law.clearance());
    }
    EXPECT_GT(least, -1e-3);
  }
  EXPECT_GT(led, 0);
}

}  // namespace
}  // namespace multireach::controller
