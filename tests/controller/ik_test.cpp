#include "controller/ik/multi_start.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <optional>

#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 34;

TEST(MultiStartIk, TheHoap2ArmHasAClosedFormAndOthersHaveNot) {
  EXPECT_TRUE(MultiStartIk(testing::hoap2()).closed_form());
  for (const auto& file : testing::shared_arm_files())
    EXPECT_FALSE(MultiStartIk(testing::load(file)).closed_form()) << file.path;
}

TEST(MultiStartIk, EveryReachablePointOfTheHoap2IsReachedInsideTheLimits) {
  const Chain chain = testing::hoap2();
  const MultiStartIk search(chain);
  const CounterRandom random(kSeed);
  for (uint64_t k = 0; k < 2000; ++k) {
    const JointVector theta = testing::random_posture(chain, random, 2 * k);
    const Eigen::Vector3d x_T = chain.position(testing::random_posture(chain, random, 2 * k + 1));
    const auto found = search.nearest(x_T, theta);
    ASSERT_TRUE(found) << "seed " << kSeed << ", case " << k;
    EXPECT_LT((chain.position(*found) - x_T).norm(), 1e-7) << k;
    EXPECT_EQ(chain.limit_excess(*found), 0) << k;
  }
}

/// A joint configuration inside the limits whose end effector is at x_T, by damped Gauss-Newton steps from `theta`,
/// clamped to the limits; written for this test. Nothing where the steps end elsewhere.
std::optional<JointVector> another_solution(const Chain& chain, const Eigen::Vector3d& x_T, JointVector theta) {
  for (int step = 0; step < 300; ++step) {
    Eigen::Vector3d x;
    PositionJacobian J;
    chain.position_and_jacobian(theta, x, J);
    const Eigen::Vector3d error = x_T - x;
    if (error.norm() < 1e-10) return theta;
    const Eigen::Matrix3d A = J * J.transpose() + 1e-8 * Eigen::Matrix3d::Identity();
    theta = chain.clamped(theta + J.transpose() * A.llt().solve(error));
  }
  return std::nullopt;
}

TEST(MultiStartIk, NoSolutionFoundByAnotherSolverIsNearer) {
  const Chain chain = testing::hoap2();
  const MultiStartIk search(chain);
  const CounterRandom random(kSeed, 1);
  int others = 0;
  for (uint64_t k = 0; k < 40; ++k) {
    const JointVector theta = testing::random_posture(chain, random, 1000 * k);
    const Eigen::Vector3d x_T = chain.position(testing::random_posture(chain, random, 1000 * k + 1));
    const double nearest = (*search.nearest(x_T, theta) - theta).norm();
    for (uint64_t j = 2; j < 100; ++j) {
      // From everywhere, and from near theta, where the nearest solutions are found.
      JointVector start = testing::random_posture(chain, random, 1000 * k + j);
      if (j % 2 == 1) start = chain.clamped(theta + 0.3 * (start - theta));
      const auto other = another_solution(chain, x_T, start);
      if (!other) continue;
      ++others;
      EXPECT_GT((*other - theta).norm(), nearest - 1e-6) << "seed " << kSeed << ", case " << k << ", other " << j;
    }
  }
  EXPECT_GT(others, 1000);
}

TEST(MultiStartIk, TheFirstPostureFoundMeetsThePoseInsideTheLimitsOfEveryArm) {
  for (const auto& file : testing::all_arm_files()) {
    const Chain chain = testing::load(file);
    const MultiStartIk search(chain);
    const CounterRandom random(kSeed, 5);
    for (uint64_t k = 0; k < 200; ++k) {
      const JointVector theta = testing::random_posture(chain, random, 2 * k);
      const Eigen::Isometry3d X = chain.pose(testing::random_posture(chain, random, 2 * k + 1));
      TaskTarget target{.position = X.translation()};
      if (chain.size() >= 6) {
        target.task = TaskKind::kPose;
        target.orientation = X.linear();
      }
      const IkSolution found = search.first(target, theta);
      ASSERT_LE(found.error_m, search.options().tolerance_m) << file.path << ", seed " << kSeed << ", case " << k;
      EXPECT_EQ(chain.limit_excess(found.theta), 0) << file.path << ", case " << k;
      EXPECT_LT((chain.position(found.theta) - target.position).norm(), 2e-7) << file.path << ", case " << k;
    }
    const TaskTarget far{.position = chain.fixed(0).translation() + 2 * chain.reach() * Eigen::Vector3d::UnitX()};
    EXPECT_GT(search.first(far, chain.clamped(JointVector::Zero(chain.size()))).error_m, 0.9 * chain.reach());
  }
}

TEST(MultiStartIk, StretchedFoldedAndLimitPosturesAreFound) {
  const Chain chain = testing::hoap2();
  const MultiStartIk search(chain);
  const JointVector middle = 0.5 * (chain.lower() + chain.upper());
  JointVector posture(4);
  for (const auto& [a, b, c, d] : {std::tuple(0.0, 0.0, 0.0, 0.0),
                                   {0.0, -M_PI / 2, 0.0, 0.0},
                                   {-1.0, -1.0, 0.2, 0.0},
                                   {0.5, -2.0, -0.3, -2.0071286397934789}}) {
    posture << a, b, c, d;
    const Eigen::Vector3d x_T = chain.position(posture);
    const auto found = search.nearest(x_T, middle);
    ASSERT_TRUE(found) << posture.transpose();
    EXPECT_LT((chain.position(*found) - x_T).norm(), 1e-7);
    EXPECT_EQ(chain.limit_excess(*found), 0);
  }
}

TEST(MultiStartIk, PointsOutOfReachHaveNoPosture) {
  const MultiStartIk search(testing::hoap2());
  const JointVector theta = JointVector::Zero(4);
  EXPECT_FALSE(search.nearest({0.3, -0.1, 0.1}, theta));
  EXPECT_FALSE(search.nearest({-0.034, -0.0995, 0.09}, theta)) << "the shoulder itself";
  EXPECT_FALSE(search.nearest({NAN, 0, 0}, theta));
  EXPECT_FALSE(search.nearest({1e9, 0, 0}, theta));
}

TEST(MultiStartIk, OtherArmsAreSearchedFromManyStarts) {
  const auto files = testing::shared_arm_files();
  if (files.empty()) GTEST_SKIP() << "the arms of shared/robots are not here";
  for (const auto& file : files) {
    const Chain chain = testing::load(file);
    const MultiStartIk search(chain);
    const CounterRandom random(kSeed);
    for (uint64_t k = 0; k < 50; ++k) {
      const JointVector theta = testing::random_posture(chain, random, 2 * k);
      const Eigen::Vector3d x_T = chain.position(testing::random_posture(chain, random, 2 * k + 1));
      const auto found = search.nearest(x_T, theta);
      ASSERT_TRUE(found) << file.path << ", seed " << kSeed << ", case " << k;
      EXPECT_LE((chain.position(*found) - x_T).norm(), 1e-7);
      EXPECT_EQ(chain.limit_excess(*found), 0);
    }
  }
}

TEST(MultiStartIk, TheSearchWithoutClosedFormComesNearTheClosedForm) {
  // With a fifth joint that can hardly move, the arm has no closed form, but almost the same nearest postures.
  const Chain arm = testing::hoap2();
  std::vector<Joint> joints = arm.joints();
  Joint stiff;
  stiff.name = "stiff";
  stiff.lower = -1e-9;
  stiff.upper = 1e-9;
  joints.push_back(stiff);
  std::vector<Eigen::Isometry3d> fixed;
  for (int i = 0; i <= 4; ++i) fixed.push_back(arm.fixed(i));
  fixed.push_back(Eigen::Isometry3d::Identity());
  const Chain five(joints, fixed, "a", "b");
  const MultiStartIk closed(arm), general(five, {.samples = 121, .starts = 64, .seed = 1, .tolerance_m = 1e-7});
  ASSERT_FALSE(general.closed_form());
  const CounterRandom random(kSeed, 2);
  int near = 0;
  constexpr int kCases = 100;
  for (uint64_t k = 0; k < kCases; ++k) {
    const JointVector theta = testing::random_posture(arm, random, 2 * k);
    const Eigen::Vector3d x_T = arm.position(testing::random_posture(arm, random, 2 * k + 1));
    JointVector theta5(5);
    theta5 << theta, 0;
    const auto a = closed.nearest(x_T, theta), b = general.nearest(x_T, theta5);
    ASSERT_TRUE(a && b) << "seed " << kSeed << ", case " << k;
    const double nearest = (*a - theta).norm(), general_distance = (b->head(4) - theta).norm();
    EXPECT_GE(general_distance, nearest - 1e-3) << k;
    near += general_distance < nearest + 0.05;
  }
  EXPECT_GE(near, 90) << "of " << kCases << ", seed " << kSeed;
}

}  // namespace
}  // namespace multireach::controller
