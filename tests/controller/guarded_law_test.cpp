#include "controller/law/guarded_law.hpp"
#include "controller/collision/proximity.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "kinematics/default_limits.hpp"
#include "tests/allocation_count.hpp"
#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 61;
constexpr double kStepsPerSecond = 140;

struct ReachStatistics {
  double error_m, path_m, distance_m, limit_excess, speed_excess, acceleration_excess;
  bool finite;
};

/// Runs a law, whose target is already set, for some nominal seconds, and records the errors and limit violations.
ReachStatistics run(GuardedLaw& law, const Eigen::Vector3d& target, double seconds,
                    const JointVector& acceleration = {}) {
  const Chain& chain = law.chain();
  ReachStatistics seen{0, 0, (target - law.x()).norm(), 0, 0, 0, true};
  Eigen::Vector3d x = law.x();
  JointVector velocity = law.velocity();
  for (int k = 0; k < seconds * kStepsPerSecond; ++k) {
    law.step();
    seen.path_m += (law.x() - x).norm();
    x = law.x();
    const JointVector now = law.velocity();
    seen.finite = seen.finite && law.theta().allFinite() && now.allFinite();
    seen.limit_excess = std::max(seen.limit_excess, chain.limit_excess(law.theta()));
    for (int i = 0; i < chain.size(); ++i) {
      seen.speed_excess = std::max(seen.speed_excess, std::abs(now[i]) * kStepsPerSecond - chain.velocity()[i]);
      if (acceleration.size() == 0) continue;
      seen.acceleration_excess =
          std::max(seen.acceleration_excess,
                   std::abs(now[i] - velocity[i]) * kStepsPerSecond * kStepsPerSecond - acceleration[i]);
    }
    velocity = now;
  }
  seen.error_m = (target - x).norm();
  return seen;
}

void expect_within_limits(const ReachStatistics& seen, const std::string& what) {
  EXPECT_TRUE(seen.finite) << what;
  EXPECT_LE(seen.limit_excess, 1e-9) << what;
  EXPECT_LE(seen.speed_excess, 1e-9) << what;
  EXPECT_LE(seen.acceleration_excess, 1e-6) << what;
}

TEST(GuardedLaw, ArrivesInsideTheLimitsOnEveryArmAtEveryGamma) {
  for (const testing::ArmFile& file : testing::all_arm_files()) {
    const Chain chain = testing::load(file);
    const CounterRandom random(kSeed);
    for (const double gamma : {0.0, 100.0, 10000.0}) {
      GuardedLaw law(chain, {.gamma = gamma});
      for (uint64_t k = 0; k < 20; ++k) {
        const Eigen::Vector3d target = chain.position(testing::random_posture(chain, random, 2 * k + 1));
        ASSERT_TRUE(law.start(testing::random_posture(chain, random, 2 * k)));
        EXPECT_EQ(law.set_target({.position = target}), TargetResult::kReachable) << file.path << ", case " << k;
        const ReachStatistics seen = run(law, target, 20);
        EXPECT_LT(seen.error_m, 1e-4) << file.path << ", seed " << kSeed << ", case " << k << ", gamma " << gamma;
        expect_within_limits(seen, file.path);
      }
    }
  }
}

// Where the joints' pull towards a far theta_T and gamma balance within a millimetre of the target, gamma must fall and
// stay low until the arm is near theta_T. These reaches of 5000 random ones had not arrived after 20 s when it did not.
TEST(GuardedLaw, DoesNotStayBesideTheTargetFarFromThetaT) {
  const Chain chain = testing::load({MULTIREACH_SOURCE_DIR "/robots/ur5/ur5.urdf", "base_link", "tool0"});
  const double reaches[][2][6] = {
      {{6.02702604756, -5.90641928357, 2.05930048793, 4.71698529119, 5.86040658446, -3.69648562327},
       {4.22429772718, -1.39575468019, 1.44984577167, 4.37392372743, 5.80908387023, -3.69648562327}},
      {{2.49522562710, -6.01229766961, 0.01863746806, -1.51655082254, 6.15827067788, -6.16460396978},
       {5.57108251623, -1.37879411378, 1.81087401740, -1.40012182771, 6.07525397873, -6.16460396978}},
      {{6.18467230050, -1.41257884558, -3.13323086887, -2.94295263987, 0.47972376519, 2.41176558809},
       {1.52994298726, 0.30114790946, -0.84821393039, -4.80371545091, 1.12772259117, 2.41176558809}}};
  for (const auto& [from, to] : reaches) {
    const JointVector start = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(from);
    const JointVector theta_target = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(to);
    GuardedLaw law(chain, {.gamma = 10000});
    ASSERT_TRUE(law.start(start));
    const Eigen::Vector3d target = chain.position(theta_target);
    ASSERT_EQ(law.set_target({.position = target}, theta_target), TargetResult::kReachable);
    const ReachStatistics seen = run(law, target, 20);
    EXPECT_LT(seen.error_m, 1e-4) << "from " << start.transpose();
    expect_within_limits(seen, "UR5");
  }
}

TEST(GuardedLaw, ArrivesInsideTheLimitsOnOddArmsOfTwoToNineJoints) {
  // tools/test.sh --full sets a larger number of arms.
  const char* number = std::getenv("MULTIREACH_ODD_ARMS");
  const uint64_t arms = number ? std::strtoull(number, nullptr, 10) : 24;
  for (uint64_t arm = 0; arm < arms; ++arm) {
    const Chain chain = testing::odd_arm(2 + static_cast<int>(arm % 8), arm);
    const CounterRandom random(kSeed, arm);
    GuardedLaw law(chain);
    for (uint64_t k = 0; k < 12; ++k) {
      const JointVector there = testing::random_posture(chain, random, 2 * k + 1);
      const Eigen::Vector3d target = chain.position(there);
      law.start(testing::random_posture(chain, random, 2 * k));
      // Only a small part of the postures reaches some targets of these arms, and the search may miss it.
      if (law.set_target({.position = target}) != TargetResult::kReachable) law.set_target({.position = target}, there);
      const ReachStatistics seen = run(law, target, 40);
      EXPECT_LT(seen.error_m, 1e-4) << "arm " << arm << ", case " << k;
      expect_within_limits(seen, "arm " + std::to_string(arm));
    }
  }
}

TEST(GuardedLaw, KeepsAccelerationsToo) {
  const Chain chain = testing::hoap2();
  const CounterRandom random(kSeed, 1);
  JointVector acceleration(4);
  acceleration << 5, 8, 10, 3;
  GuardedLaw law(chain, {.gamma = 350, .acceleration = acceleration});
  for (uint64_t k = 0; k < 40; ++k) {
    const Eigen::Vector3d target = chain.position(testing::random_posture(chain, random, 2 * k + 1));
    law.start(testing::random_posture(chain, random, 2 * k));
    law.set_target({.position = target});
    const ReachStatistics seen = run(law, target, 25, acceleration);
    EXPECT_LT(seen.error_m, 1e-4) << k;
    expect_within_limits(seen, std::to_string(k));
  }
}

TEST(GuardedLaw, ATargetThatJumpsEveryMomentBreaksNoLimit) {
  const Chain chain = testing::hoap2();
  const CounterRandom random(kSeed, 2);
  JointVector acceleration = JointVector::Constant(4, 20);
  GuardedLaw law(chain, {.gamma = 10000, .acceleration = acceleration});
  ASSERT_TRUE(law.start(JointVector::Zero(4)));
  for (uint64_t k = 0; k < 2000; ++k) {
    law.set_target({.position = chain.position(testing::random_posture(chain, random, k))});
    expect_within_limits(run(law, Eigen::Vector3d::Zero(), 0.05, acceleration), std::to_string(k));
  }
}

/// The largest acceleration of each joint, in shares of its default limit, under targets that jump.
double largest_share_of_acceleration(const Chain& chain, const GuardedParameters& parameters) {
  const CounterRandom random(kSeed, 8);
  GuardedLaw law(chain, parameters);
  law.start(testing::random_posture(chain, random, 0));
  const JointVector limit = default_acceleration(chain.velocity());
  JointVector velocity = law.velocity();
  double most = 0;
  for (uint64_t k = 0; k < 200; ++k) {
    law.set_target({.position = chain.position(testing::random_posture(chain, random, k + 1))});
    for (int step = 0; step < 70; ++step) {
      law.step();
      const JointVector change = (law.velocity() - velocity) * kStepsPerSecond * kStepsPerSecond;
      most = std::max(most, change.cwiseQuotient(limit).cwiseAbs().maxCoeff());
      velocity = law.velocity();
    }
  }
  return most;
}

TEST(GuardedLaw, WithoutConfigurationAJointReachesItsSpeedInATenthOfASecondAtTheEarliest) {
  for (const Chain& chain : {testing::hoap2(), testing::six_joint_arm().chain, testing::odd_arm(6, 3)}) {
    EXPECT_LE(largest_share_of_acceleration(chain, {}), 1 + 1e-9);
    const JointVector none = JointVector::Constant(chain.size(), INFINITY);
    EXPECT_GT(largest_share_of_acceleration(chain, {.acceleration = none}), 1.2) << "none: the test can fail";
  }
}

TEST(GuardedLaw, SingularPosturesAreLikeAnyOther) {
  // Stretched down, stretched sideways, stretched forward, folded, on the axis of a joint: from each to each.
  const Chain chain = testing::hoap2();
  std::vector<JointVector> postures;
  for (const auto& [a, b, c, d] : {std::tuple(0.0, 0.0, 0.0, 0.0),
                                   {0.0, -M_PI / 2, 0.0, 0.0},
                                   {-M_PI / 2, 0.0, 0.0, 0.0},
                                   {0.3, -M_PI / 2, 0.1, -2.007},
                                   {0.0, -0.001, 0.0, -1e-9},
                                   {-1.0, -1.0, 0.2, 0.0}}) {
    postures.push_back((JointVector(4) << a, b, c, d).finished());
  }
  for (const JointVector& start : postures) {
    for (const JointVector& goal : postures) {
      GuardedLaw law(chain, {.gamma = 350});
      law.start(start);
      const Eigen::Vector3d target = chain.position(goal);
      EXPECT_EQ(law.set_target({.position = target}), TargetResult::kReachable);
      const ReachStatistics seen = run(law, target, 10);
      EXPECT_LT(seen.error_m, 1e-4) << start.transpose() << " to " << goal.transpose();
      expect_within_limits(seen, "singular");
    }
  }
}

TEST(GuardedLaw, StartedOutsideALimitItComesBackMonotonically) {
  const Chain chain = testing::hoap2();
  JointVector start(4);
  start << 1.9, -3.4, 0.9, 0.3;
  GuardedLaw law(chain);
  ASSERT_TRUE(law.start(start));
  law.set_target({.position = {0.1, -0.12, 0.1}});
  double excess = chain.limit_excess(law.theta());
  for (int k = 0; k < 1400; ++k) {
    law.step();
    const double now = chain.limit_excess(law.theta());
    ASSERT_LE(now, excess);
    excess = now;
  }
  EXPECT_LT(excess, 1e-6);
  EXPECT_LT((law.x() - Eigen::Vector3d(0.1, -0.12, 0.1)).norm(), 1e-4);
}

TEST(GuardedLaw, TurnsTheHandAsAsked) {
  for (const auto& [name, chain] : testing::pose_arms()) {
    const CounterRandom random(kSeed, 3);
    for (const TaskKind task : {TaskKind::kPointing, TaskKind::kPose}) {
      GuardedLaw law(chain);
      for (uint64_t k = 0; k < 10; ++k) {
        const JointVector there = testing::random_posture(chain, random, 2 * k + 1, 0.1);
        const Eigen::Isometry3d X = chain.pose(there);
        const TaskTarget target{
            .position = X.translation(), .task = task, .direction = X.linear().col(2), .orientation = X.linear()};
        law.start(testing::random_posture(chain, random, 2 * k));
        EXPECT_EQ(law.set_target(target), TargetResult::kReachable) << name << " " << k;
        expect_within_limits(run(law, target.position, 30), name);
        const Eigen::Isometry3d reached = chain.pose(law.theta());
        EXPECT_LT((reached.translation() - X.translation()).norm(), 1e-4) << name << " " << k;
        const double angle = task == TaskKind::kPose
                                 ? Eigen::AngleAxisd(reached.linear().transpose() * X.linear()).angle()
                                 : std::acos(std::min(1.0, reached.linear().col(2).dot(X.linear().col(2))));
        EXPECT_LT(angle, 2e-3) << name << " " << k;
      }
    }
  }
}

TEST(GuardedLaw, GoesToAPosture) {
  const Chain chain = testing::hoap2();
  JointVector posture(4);
  posture << 0.3, -0.5, -0.3, -1;
  GuardedLaw law(chain);
  ASSERT_TRUE(law.start(JointVector::Zero(4)));
  ASSERT_TRUE(law.set_joint_target(posture));
  for (int k = 0; k < 700; ++k) law.step();
  EXPECT_LT((law.theta() - posture).norm(), 1e-5);
  EXPECT_FALSE(law.set_joint_target(JointVector::Constant(4, 3)));
}

TEST(GuardedLaw, RefusesWhatMakesNoSense) {
  const Chain chain = testing::hoap2();
  GuardedLaw law(chain);
  ASSERT_TRUE(law.start(JointVector::Zero(4)));
  const JointVector before = law.theta();
  EXPECT_FALSE(law.start(JointVector::Zero(3)));
  EXPECT_FALSE(law.start(JointVector::Constant(4, NAN)));
  EXPECT_FALSE(law.start(JointVector::Constant(4, 1e6)));
  EXPECT_EQ(law.set_target({.position = {0, NAN, 0}}), TargetResult::kRefused);
  EXPECT_EQ(law.set_target({.velocity = {INFINITY, 0, 0}}), TargetResult::kRefused);
  EXPECT_EQ(law.set_target({.task = TaskKind::kPointing, .direction = {0, 0, 2}}), TargetResult::kRefused);
  EXPECT_EQ(law.set_target({.task = TaskKind::kPose, .orientation = Eigen::Matrix3d::Constant(1)}),
            TargetResult::kRefused);
  EXPECT_EQ(law.set_target({}, JointVector::Constant(4, 3)), TargetResult::kRefused) << "outside the limits";
  law.compensate(JointVector::Constant(4, NAN));
  for (int k = 0; k < 100; ++k) law.step();
  EXPECT_EQ(before, law.theta()) << "without a target the arm stays";
  for (const double bad : {-1.0, 0.0, double(NAN)}) {
    EXPECT_THROW(GuardedLaw(chain, {.steps_per_second = bad}), std::invalid_argument);
    EXPECT_THROW(GuardedLaw(chain, {.extrapolation_s = bad}), std::invalid_argument);
    EXPECT_THROW(GuardedLaw(chain, {.acceleration = JointVector::Constant(4, bad)}), std::invalid_argument);
    EXPECT_THROW(GuardedLaw(chain, {.tool = {.orientation_length_m = bad}}), std::invalid_argument);
  }
  EXPECT_THROW(GuardedLaw(chain, {.gamma = -1}), std::invalid_argument);
  EXPECT_THROW(GuardedLaw(chain, {.tool = {.axis = {1, 1, 0}}}), std::invalid_argument);
  EXPECT_THROW(GuardedLaw(chain, {.body = {.link_radius_m = -1}}), std::invalid_argument);
}

TEST(GuardedLaw, ACopyGoesOnAlone) {
  const Chain chain = testing::hoap2();
  GuardedLaw law(chain);
  law.start(JointVector::Zero(4));
  law.set_target({.position = {0.1, -0.12, 0.1}});
  for (int k = 0; k < 50; ++k) law.step();
  GuardedLaw copy = law;
  for (int k = 0; k < 50; ++k) copy.step();
  const JointVector later = copy.theta();
  EXPECT_NE(law.theta(), later);
  for (int k = 0; k < 50; ++k) law.step();
  EXPECT_EQ(law.theta(), later) << "to the bit";
  copy = law;
  EXPECT_EQ(copy.theta(), later);
}

std::vector<Obstacle> wall() {
  Obstacle box{.shape = Obstacle::Shape::kBox, .size = {0.06, 0.02, 0.12}};
  box.X_WO.translation() = Eigen::Vector3d(0.14, -0.14, 0.08);
  Obstacle ball{.shape = Obstacle::Shape::kSphere, .size = {0.03, 0, 0}};
  ball.X_WO.translation() = Eigen::Vector3d(0.02, -0.25, 0.05);
  return {box, ball};
}

TEST(GuardedLaw, GoesAroundAWallAndTouchesNothing) {
  const Chain chain = testing::hoap2();
  const GuardedParameters parameters{.body = {.link_radius_m = 0.02}};
  GuardedLaw law(chain, parameters);
  JointVector start(4), there(4);
  start << -0.9, -0.1, 0.3, -1.2;
  there << -0.9, -1.1, -0.3, -1.1;
  Proximity proximity(chain, parameters.body);
  Obstacle box{.shape = Obstacle::Shape::kBox, .size = {0.10, 0.01, 0.06}};
  box.X_WO.translation() = 0.5 * (chain.position(start) + chain.position(there));
  proximity.set_obstacles({&box, 1});
  ASSERT_GT(proximity.clearance(start), 0);
  ASSERT_GT(proximity.clearance(there), 0);
  EXPECT_EQ(law.set_obstacles({&box, 1}), 0);
  law.start(start);
  const Eigen::Vector3d target = chain.position(there);
  law.set_target({.position = target});
  double least = 1;
  for (int k = 0; k < 2800; ++k) {
    law.step();
    least = std::min(least, proximity.clearance(law.theta()));
  }
  EXPECT_GT(least, -0.5e-3) << "of the margin of 5 mm";
  EXPECT_LT((law.x() - target).norm(), 1e-4);
}

TEST(GuardedLaw, ATargetInsideAnObstacleIsApproachedToItsSurface) {
  const Chain chain = testing::hoap2();
  const GuardedParameters parameters{.body = {.link_radius_m = 0.02, .margin_m = 0.004}};
  GuardedLaw law(chain, parameters);
  Obstacle ball{.shape = Obstacle::Shape::kSphere, .size = {0.03, 0, 0}};
  ball.X_WO.translation() = Eigen::Vector3d(0.12, -0.15, 0.1);
  law.set_obstacles({&ball, 1});
  JointVector start(4);
  start << 0.2, -0.3, -0.2, -0.9;
  law.start(start);
  law.set_target({.position = ball.X_WO.translation() + Eigen::Vector3d(-0.01, 0, 0)});
  for (int k = 0; k < 2000; ++k) law.step();
  EXPECT_NEAR((law.x() - ball.X_WO.translation()).norm(), 0.03 + 0.02 + 0.004, 1e-3);
  EXPECT_LT(law.velocity().norm() * kStepsPerSecond, 1e-2) << "calm";
}

TEST(GuardedLaw, RestsAsNearAsItCanBeToTargetsInsideBalls) {
  const Chain chain = testing::hoap2();
  const GuardedParameters parameters{.acceleration = JointVector::Constant(4, 60), .body = {.link_radius_m = 0.02}};
  const CounterRandom random(kSeed, 6);
  const JointVector start = (JointVector(4) << 0.2, -0.3, -0.2, -0.9).finished();
  Proximity proximity(chain, parameters.body);
  int cases = 0;
  for (uint64_t k = 0; k < 25; ++k) {
    Obstacle ball{.shape = Obstacle::Shape::kSphere, .size = {0.05, 0, 0}};
    ball.X_WO.translation() = chain.position(testing::random_posture(chain, random, k, 0.1));
    proximity.set_obstacles({&ball, 1});
    if (proximity.clearance(start) < 0.005) continue;  // the ball is on the arm
    ++cases;
    // The nearest collision-free hand position among random postures.
    double nearest = 1;
    for (uint64_t j = 0; j < 3000; ++j) {
      const JointVector posture = testing::random_posture(chain, random, 1000 + j);
      const double distance = (chain.position(posture) - ball.X_WO.translation()).norm();
      if (distance < nearest && proximity.clearance(posture) >= 0) nearest = distance;
    }
    GuardedLaw law(chain, parameters);
    law.start(start);
    law.set_obstacles({&ball, 1});
    law.set_target({.position = ball.X_WO.translation()});
    double fastest = 0;
    for (int step = 0; step < 60 * 140; ++step) {
      law.step();
      if (step > 50 * 140) fastest = std::max(fastest, law.velocity().norm() * kStepsPerSecond);
    }
    EXPECT_LT((law.x() - ball.X_WO.translation()).norm(), nearest + 0.005) << "seed " << kSeed << ", case " << k;
    EXPECT_LT(fastest, 1e-3) << "seed " << kSeed << ", case " << k;
    EXPECT_FALSE(law.following_path()) << "seed " << kSeed << ", case " << k;
  }
  EXPECT_GE(cases, 15) << "of 25 balls, most leave the arm free";
}

TEST(GuardedLaw, GoesToItsTargetWhenTheObstacleAroundItIsGone) {
  const Chain chain = testing::hoap2();
  GuardedLaw law(chain, {.body = {.link_radius_m = 0.02}});
  const Eigen::Vector3d target(0.12, -0.15, 0.1);
  Obstacle ball{.shape = Obstacle::Shape::kSphere, .size = {0.03, 0, 0}};
  ball.X_WO.translation() = target;
  law.start((JointVector(4) << 0.2, -0.3, -0.2, -0.9).finished());
  law.set_target({.position = target});
  law.set_obstacles({&ball, 1});  // appears after the target is set; removed below
  for (int k = 0; k < 2000; ++k) law.step();
  EXPECT_GT((law.x() - target).norm(), 0.03 + 0.02);
  law.set_obstacles({});
  for (int k = 0; k < 2000; ++k) law.step();
  EXPECT_LT((law.x() - target).norm(), 1e-4);
}

/// Steps until the law plans or, with `path`, follows a planned path; `most` when it does not.
int steps_to_a_plan(GuardedLaw& law, int most, bool path = false) {
  int steps = 0;
  while (steps < most && !law.following_path() && (path || !law.planning())) {
    law.step();
    ++steps;
  }
  return steps;
}

TEST(GuardedLaw, ANewGoalIsPlannedForAsSoonAsTheFirstOneHoweverOftenPlansFailed) {
  const Chain chain = testing::hoap2();
  const GuardedParameters parameters{.body = {.link_radius_m = 0.02}};
  JointVector start(4), there(4);
  start << -0.9, -0.1, 0.3, -1.2;
  there << -0.9, -1.1, -0.3, -1.1;
  Obstacle box{.shape = Obstacle::Shape::kBox, .size = {0.10, 0.01, 0.06}};
  box.X_WO.translation() = 0.5 * (chain.position(start) + chain.position(there));
  Obstacle ball{.shape = Obstacle::Shape::kSphere, .size = {0.05, 0, 0}};
  ball.X_WO.translation() = chain.position(there);
  // For 20 s the goal is inside the ball, so every plan fails and the law waits longer and longer before the next one.
  GuardedLaw weary(chain, parameters);
  weary.start(start);
  weary.set_obstacles(std::vector{box, ball});
  weary.set_joint_target(there);
  EXPECT_EQ(steps_to_a_plan(weary, 2800, true), 2800) << "there is no path";
  weary.set_obstacles({&box, 1});
  const TaskTarget target{.position = chain.position(there)};
  const auto after = [&](const auto& set_goal) {
    GuardedLaw law = weary, fresh(chain, parameters);
    fresh.start(law.theta());
    fresh.set_obstacles({&box, 1});
    set_goal(law);
    set_goal(fresh);
    const int steps = steps_to_a_plan(law, 1400), first = steps_to_a_plan(fresh, 1400);
    EXPECT_LT(first, 1400);
    EXPECT_LE(steps, first + 7) << "steps; a tick is 7";
  };
  after([&](GuardedLaw& law) { law.set_target(target); });
  after([&](GuardedLaw& law) { law.set_target(target, there); });
  after([&](GuardedLaw& law) { law.set_joint_target(there); });
  EXPECT_GT(steps_to_a_plan(weary, 1400), 140) << "the old goal is planned for when its turn comes: the test can fail";
}

TEST(GuardedLaw, AChangeOfTheTaskIsNoImpulse) {
  for (const auto& [name, chain] : testing::pose_arms()) {
    GuardedLaw law(chain);
    const CounterRandom random(kSeed, 5);
    const Eigen::Isometry3d first = chain.pose(testing::random_posture(chain, random, 1, 0.2));
    law.start(testing::random_posture(chain, random, 0, 0.2));
    law.set_target({.position = first.translation(), .task = TaskKind::kPose, .orientation = first.linear()});
    for (int k = 0; k < 40; ++k) law.step();
    law.set_joint_target(chain.clamped(law.theta()));
    for (int k = 0; k < 3000; ++k) law.step();
    const Eigen::Isometry3d here = chain.pose(law.theta());
    law.set_target({.position = here.translation(), .task = TaskKind::kPose, .orientation = here.linear()},
                   law.theta());
    law.step();
    EXPECT_LT(law.velocity().norm() * kStepsPerSecond, 1e-4) << name;
  }
}

TEST(GuardedLaw, StepsAllocateNothing) {
  const Chain chain = testing::hoap2();
  GuardedLaw law(chain, {.body = {.link_radius_m = 0.02}});
  const std::vector<Obstacle> obstacles = wall();
  const CounterRandom random(kSeed, 4);
  std::vector<Eigen::Vector3d> targets;
  for (uint64_t k = 0; k < 20; ++k) {
    targets.push_back(chain.position(testing::random_posture(chain, random, k)));
  }
  law.set_obstacles(obstacles);
  law.start(JointVector::Zero(4));
  const int64_t before = testing::allocations().number;
  for (const Eigen::Vector3d& target : targets) {
    law.set_target({.position = target});
    for (int k = 0; k < 400; ++k) law.step();
  }
  EXPECT_EQ(testing::allocations().number, before);
}

}  // namespace
}  // namespace multireach::controller
