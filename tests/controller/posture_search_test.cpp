#include "controller/ik/posture_search.hpp"

#include <gtest/gtest.h>

#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 34;

TEST(PostureSearch, TheHoap2ArmHasAClosedFormAndOthersHaveNot) {
  EXPECT_TRUE(PostureSearch(testing::hoap2()).closed_form());
  for (const auto& file : testing::shared_arm_files())
    EXPECT_FALSE(PostureSearch(testing::load(file)).closed_form()) << file.path;
}

TEST(PostureSearch, EveryReachablePointOfTheHoap2IsReachedInsideTheLimits) {
  const Chain chain = testing::hoap2();
  const PostureSearch search(chain);
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

TEST(PostureSearch, NothingFoundByChanceIsNearer) {
  // Postures drawn along the self-motion of random solutions, none of which may be clearly nearer.
  const Chain chain = testing::hoap2();
  const PostureSearch search(chain);
  const CounterRandom random(kSeed, 1);
  for (uint64_t k = 0; k < 40; ++k) {
    const JointVector theta = testing::random_posture(chain, random, 1000 * k);
    const Eigen::Vector3d x_T = chain.position(testing::random_posture(chain, random, 1000 * k + 1));
    const double nearest = (*search.nearest(x_T, theta) - theta).norm();
    for (uint64_t j = 2; j < 400; ++j) {
      // The nearest posture to another theta is some posture that reaches the target.
      const auto other = search.nearest(x_T, testing::random_posture(chain, random, 1000 * k + j));
      EXPECT_GT((*other - theta).norm(), nearest - 1e-6) << "seed " << kSeed << ", case " << k << ", other " << j;
    }
  }
}

TEST(PostureSearch, TheFirstPostureFoundMeetsThePoseInsideTheLimitsOfEveryArm) {
  for (const auto& file : testing::all_arm_files()) {
    const Chain chain = testing::load(file);
    const PostureSearch search(chain);
    const CounterRandom random(kSeed, 5);
    for (uint64_t k = 0; k < 200; ++k) {
      const JointVector theta = testing::random_posture(chain, random, 2 * k);
      const Eigen::Isometry3d X = chain.pose(testing::random_posture(chain, random, 2 * k + 1));
      HandTarget target{.position = X.translation()};
      if (chain.size() >= 6) {
        target.aim = Aim::kPose;
        target.orientation = X.linear();
      }
      const FoundPosture found = search.first(target, theta);
      ASSERT_LE(found.error_m, search.options().tolerance_m) << file.path << ", seed " << kSeed << ", case " << k;
      EXPECT_EQ(chain.limit_excess(found.theta), 0) << file.path << ", case " << k;
      EXPECT_LT((chain.position(found.theta) - target.position).norm(), 2e-7) << file.path << ", case " << k;
    }
    const HandTarget far{.position = chain.fixed(0).translation() + 2 * chain.reach() * Eigen::Vector3d::UnitX()};
    EXPECT_GT(search.first(far, chain.clamped(JointVector::Zero(chain.size()))).error_m, 0.9 * chain.reach());
  }
}

TEST(PostureSearch, StretchedFoldedAndLimitPosturesAreFound) {
  const Chain chain = testing::hoap2();
  const PostureSearch search(chain);
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

TEST(PostureSearch, PointsOutOfReachHaveNoPosture) {
  const PostureSearch search(testing::hoap2());
  const JointVector theta = JointVector::Zero(4);
  EXPECT_FALSE(search.nearest({0.3, -0.1, 0.1}, theta));
  EXPECT_FALSE(search.nearest({-0.034, -0.0995, 0.09}, theta)) << "the shoulder itself";
  EXPECT_FALSE(search.nearest({NAN, 0, 0}, theta));
  EXPECT_FALSE(search.nearest({1e9, 0, 0}, theta));
}

TEST(PostureSearch, OtherArmsAreSearchedFromManyStarts) {
  const auto files = testing::shared_arm_files();
  if (files.empty()) GTEST_SKIP() << "the arms of shared/robots are not here";
  for (const auto& file : files) {
    const Chain chain = testing::load(file);
    const PostureSearch search(chain);
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

TEST(PostureSearch, TheSearchWithoutClosedFormComesNearTheClosedForm) {
  // The same arm with a fifth joint that can hardly move has no closed form, but almost the same nearest postures.
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
  const PostureSearch closed(arm), general(five, {.samples = 121, .starts = 64, .seed = 1, .tolerance_m = 1e-7});
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
