// Joints that are slow, heavy or locked.
#include <gtest/gtest.h>

#include <algorithm>

#include "controller/law/guarded_law.hpp"
#include "controller/task/joint_weights.hpp"
#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 61;
constexpr double kStepsPerSecond = 140;

/// `arm` on a lift at `speed`, m/s, that comes first.
Chain on_a_lift(const Chain& arm, double speed) {
  std::vector<Joint> joints = arm.joints();
  joints.insert(
      joints.begin(),
      {.name = "lift", .type = Joint::Type::kPrismatic, .lower = 0, .upper = 0.2, .velocity = speed, .effort = 1000});
  std::vector<Eigen::Isometry3d> fixed{Eigen::Isometry3d::Identity()};
  for (int i = 0; i <= arm.size(); ++i) fixed.push_back(arm.fixed(i));
  return Chain(joints, fixed, "torso", "hand");
}

/// The time until the hand stays within 1 mm of its target, s, for each of some reaches to what the arm itself reaches,
/// and the distance that the first joint moves, m.
std::vector<std::pair<double, double>> settling(const Chain& chain, const Chain& arm, uint64_t reaches) {
  const CounterRandom random(kSeed, 9);
  GuardedLaw law(chain);
  std::vector<std::pair<double, double>> settled;
  for (uint64_t k = 0; k < reaches; ++k) {
    const Eigen::Vector3d target = arm.position(testing::random_posture(arm, random, 2 * k + 1));
    JointVector start = testing::random_posture(arm, random, 2 * k);
    const bool lifted = chain.size() > arm.size();
    if (lifted) start = (JointVector(chain.size()) << 0.0, start).finished();
    law.start(start);
    EXPECT_EQ(law.set_target({.position = target}), TargetResult::kReachable) << k;
    int last = 0;
    for (int step = 1; step <= 20 * 140; ++step) {
      law.step();
      if ((law.x() - target).norm() > 1e-3) last = step;
    }
    EXPECT_LT((law.x() - target).norm(), 1e-4) << "case " << k << ", seed " << kSeed;
    EXPECT_LE(chain.limit_excess(law.theta()), 0) << k;
    settled.emplace_back(last / kStepsPerSecond, std::abs(law.theta()[0] - start[0]));
  }
  std::ranges::sort(settled);
  return settled;
}

TEST(JointWeights, ASlowLiftStaysWhereItIsWhereTheArmAloneReaches) {
  for (const auto& [name, arm] : {testing::six_joint_arm(), testing::seven_joint_arm()}) {
    const Chain lifted = on_a_lift(arm, 0.013);
    const auto with = settling(lifted, arm, 60), alone = settling(arm, arm, 60);
    EXPECT_LT(with[30].first, 1.5 * alone[30].first) << name;
    EXPECT_LT(with[57].first, 1.5 * alone[57].first) << name << ", the slowest";
    for (const auto& [seconds, moved] : with) EXPECT_LT(moved, 0.03) << name;
  }
}

TEST(JointWeights, AHeavyJointMovesLessThanALightOne) {
  const Chain chain = testing::seven_joint_arm().chain;
  const CounterRandom random(kSeed, 10);
  JointVector weights = JointVector::Ones(7);
  weights[2] = 3;
  GuardedLaw equal(chain), heavy(chain, {.joint_weights = 5 * weights}), same(chain, {.joint_weights = weights});
  double moved = 0, moved_heavy = 0;
  for (uint64_t k = 0; k < 40; ++k) {
    const JointVector start = testing::random_posture(chain, random, 2 * k);
    const Eigen::Vector3d target = chain.position(testing::random_posture(chain, random, 2 * k + 1));
    for (GuardedLaw* law : {&equal, &heavy, &same}) {
      law->start(start);
      law->set_target({.position = target});
      for (int step = 0; step < 10 * kStepsPerSecond; ++step) law->step();
      EXPECT_LE(chain.limit_excess(law->theta()), 0) << k;
      EXPECT_LT((law->x() - target).norm(), 1e-4) << k;
    }
    EXPECT_EQ(heavy.theta(), same.theta()) << "only the ratios of the weights matter";
    moved += std::abs(equal.theta()[2] - start[2]);
    moved_heavy += std::abs(heavy.theta()[2] - start[2]);
  }
  EXPECT_LT(moved_heavy, 0.5 * moved);
}

TEST(JointWeights, ALockedJointNeverMoves) {
  for (const Chain& chain : {testing::seven_joint_arm().chain, testing::hoap2()}) {
    const CounterRandom random(kSeed, 11);
    for (int locked = 0; locked < chain.size(); ++locked) {
      JointVector weights = JointVector::Ones(chain.size());
      weights[locked] = INFINITY;
      GuardedLaw law(chain, {.joint_weights = weights, .body = {.link_radius_m = 0.02}});
      for (uint64_t k = 0; k < 6; ++k) {
        JointVector start = testing::random_posture(chain, random, 3 * k),
                    there = testing::random_posture(chain, random, 3 * k + 1);
        if (k % 3 == 2) start[locked] += 4;  // outside its limits
        const double at = there[locked] = start[locked];
        law.start(start);
        const Eigen::Vector3d target = chain.position(there);
        const bool reachable = law.set_target({.position = target}) == TargetResult::kReachable;
        if (k == 4) law.set_target({.position = target}, testing::random_posture(chain, random, 3 * k + 2));
        if (k == 5) law.compensate(JointVector::Constant(chain.size(), 0.1));
        Obstacle ball{.shape = Obstacle::Shape::kSphere, .size = {0.03, 0, 0}};
        ball.X_WO.translation() = 0.5 * (law.x() + target);
        law.set_obstacles({&ball, k % 2});
        for (int step = 0; step < 1400; ++step) {
          law.step();
          ASSERT_EQ(law.theta()[locked], at) << "joint " << locked << ", case " << k << ", step " << step;
        }
        if (reachable && k % 2 == 0 && k != 4) {
          EXPECT_LT((law.x() - target).norm(), 1e-3) << locked << ", case " << k;
        }
        EXPECT_TRUE(law.set_joint_target(chain.clamped(there)));
        for (int step = 0; step < 300; ++step) law.step();
        ASSERT_EQ(law.theta()[locked], at);
      }
    }
  }
}

TEST(JointWeights, RefusesWeightsThatMakeNoSense) {
  const Chain chain = testing::hoap2();
  const auto with = [&](double first, double others, int size) {
    JointVector weights = JointVector::Constant(size, others);
    weights[0] = first;
    return GuardedParameters{.joint_weights = weights};
  };
  for (const double bad : {0.0, -1.0, double(NAN)})
    EXPECT_THROW(GuardedLaw(chain, with(bad, 1, 4)), std::invalid_argument);
  EXPECT_THROW(GuardedLaw(chain, with(1, 1, 3)), std::invalid_argument);
  EXPECT_THROW(GuardedLaw(chain, with(INFINITY, INFINITY, 4)), std::invalid_argument) << "all locked";
  EXPECT_NO_THROW(GuardedLaw(chain, with(INFINITY, 1, 4)));
}

TEST(JointWeights, OnlyJointsMuchSlowerThanTheOthersWeighMore) {
  for (const testing::ArmFile& file : testing::all_arm_files()) {
    const Chain chain = testing::load(file);
    EXPECT_EQ(default_joint_weights(chain), JointVector::Ones(chain.size())) << file.path;
  }
  const Chain arm = testing::seven_joint_arm().chain;  // of 2 rad/s
  const auto of_lift = [&](double speed) { return default_joint_weights(on_a_lift(arm, speed))[0]; };
  EXPECT_EQ(of_lift(2.0 / 7), 1);
  EXPECT_DOUBLE_EQ(of_lift(0.1), 20);
  EXPECT_EQ(of_lift(0.013), 30) << "at most";
  EXPECT_EQ(of_lift(0), 1) << "it does not move";
  EXPECT_EQ(of_lift(INFINITY), 1);
}

}  // namespace
}  // namespace multireach::controller
