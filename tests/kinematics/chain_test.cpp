#include "kinematics/chain.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "kinematics/default_joint_position.hpp"
#include "tests/test_arms.hpp"

namespace multireach {
namespace {

using testing::hoap2;

constexpr uint64_t kSeed = 20081;

class EveryArm : public ::testing::TestWithParam<testing::ArmFile> {};

TEST_P(EveryArm, JacobianIsTheDerivativeOfPositionAndOrientation) {
  const Chain chain = testing::load(GetParam());
  const CounterRandom random(kSeed);
  for (uint64_t k = 0; k < 20; ++k) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", posture " + std::to_string(k));
    const JointVector theta = testing::random_posture(chain, random, k);
    Eigen::Isometry3d X_WT;
    PoseJacobian pose_jacobian;
    chain.pose_and_jacobian(theta, X_WT, pose_jacobian);
    Eigen::Vector3d p_WT;
    PositionJacobian jacobian;
    chain.position_and_jacobian(theta, p_WT, jacobian);
    EXPECT_TRUE(p_WT.isApprox(X_WT.translation(), 1e-14));
    EXPECT_TRUE(jacobian.isApprox(pose_jacobian.topRows<3>(), 1e-14));
    constexpr double kStep = 1e-6;
    for (int i = 0; i < chain.size(); ++i) {
      JointVector ahead = theta, behind = theta;
      ahead[i] += kStep;
      behind[i] -= kStep;
      const Eigen::Isometry3d X_ahead = chain.pose(ahead), X_behind = chain.pose(behind);
      const Eigen::Vector3d velocity = (X_ahead.translation() - X_behind.translation()) / (2 * kStep);
      EXPECT_LT((velocity - jacobian.col(i)).norm(), 1e-8) << chain.joint(i).name;
      const Eigen::AngleAxisd turn(X_ahead.linear() * X_behind.linear().transpose());
      const Eigen::Vector3d angular_velocity = turn.axis() * turn.angle() / (2 * kStep);
      EXPECT_LT((angular_velocity - pose_jacobian.col(i).tail<3>()).norm(), 1e-8) << chain.joint(i).name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Arms, EveryArm, ::testing::ValuesIn(testing::all_arm_files()),
                         [](const auto& arm) { return std::filesystem::path(arm.param.path).stem().string(); });

TEST(Chain, Hoap2HangsDownAtZeroAndReachesForward) {
  const Chain chain = hoap2();
  ASSERT_EQ(chain.size(), 4);
  EXPECT_EQ(chain.joint(3).name, "right_EB");
  const Eigen::Vector3d shoulder(-0.034, -0.0995, 0.09);
  JointVector theta = JointVector::Zero(4);
  EXPECT_TRUE(chain.position(theta).isApprox(shoulder + Eigen::Vector3d(0, 0, -0.217), 1e-12));
  theta << -M_PI / 2, 0, 0, 0;  // flexion: forward
  EXPECT_TRUE(chain.position(theta).isApprox(shoulder + Eigen::Vector3d(0.217, 0, 0), 1e-12));
  theta << 0, -M_PI / 2, 0, 0;  // abduction: to the robot's right
  EXPECT_TRUE(chain.position(theta).isApprox(shoulder + Eigen::Vector3d(0, -0.217, 0), 1e-12));
  theta << 0, 0, 0, -M_PI / 2;  // elbow: forearm forward
  EXPECT_TRUE(chain.position(theta).isApprox(shoulder + Eigen::Vector3d(0.101, 0, -0.116), 1e-12));
}

TEST(Chain, Hoap2LargestSingularValueIsThatOfTheStretchedArm) {
  // Two joints have parallel axes with lever arms of 0.217 and 0.101 m, so sigma_1^2 = 0.217^2 + 0.101^2.
  const Chain chain = hoap2();
  Eigen::Vector3d p;
  PositionJacobian J;
  chain.position_and_jacobian(JointVector::Zero(4), p, J);
  const double sigma2 = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(J * J.transpose()).eigenvalues()[2];
  EXPECT_NEAR(sigma2, 0.217 * 0.217 + 0.101 * 0.101, 1e-12);
}

TEST(Chain, LeftArmMirrorsTheRight) {
  const Chain right = hoap2();
  const Chain left = chain_from_urdf(testing::file_text(testing::hoap2_file().path), "torso", "left_hand");
  const CounterRandom random(kSeed);
  for (uint64_t k = 0; k < 50; ++k) {
    const JointVector theta = testing::random_posture(right, random, k);
    Eigen::Vector3d mirrored = right.position(theta);
    mirrored.y() *= -1;
    EXPECT_TRUE(left.position(theta).isApprox(mirrored, 1e-12));
  }
}

TEST(Chain, ReadFromTipToBaseItIsTheInverse) {
  const testing::ArmFile file = testing::hoap2_file();
  const Chain forward = testing::load(file);
  const Chain backward = chain_from_urdf(testing::file_text(file.path), file.tip, file.base);
  const CounterRandom random(kSeed);
  const JointVector theta = testing::random_posture(forward, random, 0);
  EXPECT_TRUE(backward.pose(theta.reverse()).isApprox(forward.pose(theta).inverse(), 1e-12));
}

TEST(Chain, GoesFromOneBranchToAnother) {
  const std::string urdf = testing::file_text(testing::hoap2_file().path);
  const Chain left = chain_from_urdf(urdf, "torso", "left_hand"), right = hoap2();
  const Chain across = chain_from_urdf(urdf, "left_hand", "right_hand");
  ASSERT_EQ(across.size(), 8);
  const CounterRandom random(kSeed);
  const JointVector a = testing::random_posture(left, random, 0), b = testing::random_posture(right, random, 1);
  JointVector both(8);
  both << a.reverse(), b;
  EXPECT_TRUE(across.pose(both).isApprox(left.pose(a).inverse() * right.pose(b), 1e-12));
}

TEST(Chain, KnowsWhatIsOutsideTheLimits) {
  const Chain chain = hoap2();
  JointVector theta(4);
  theta << 0, 0.1, 0, -2.5;
  EXPECT_NEAR(chain.limit_excess(theta), 2.5 - 2.0071286397934789, 1e-15);
  EXPECT_EQ(chain.limit_excess(chain.clamped(theta)), 0);
  EXPECT_EQ(default_joint_position(-1, 2), 0);
  EXPECT_EQ(default_joint_position(0, 2), 0);
  EXPECT_EQ(default_joint_position(-2, -1), -1.5);
  EXPECT_EQ(default_joint_position(-HUGE_VAL, HUGE_VAL), 0);
  EXPECT_TRUE(joint_configuration_fault(chain, {0, 0.1, 0, -1}, "the start")->find("right_SAA") != std::string::npos);
  EXPECT_TRUE(joint_configuration_fault(chain, {0, 0, 0}, "the start")->find("4 joints") != std::string::npos);
  EXPECT_TRUE(joint_configuration_fault(chain, {0, 0, NAN, 0}, "the start")->find("right_SHR") != std::string::npos);
  EXPECT_FALSE(joint_configuration_fault(chain, {0, 0, 0, 0}, "the start"));
}

TEST(CounterRandom, IsUniformAndAddressable) {
  const CounterRandom random(kSeed), other(kSeed, 1);
  double sum = 0, sum2 = 0;
  constexpr int kCount = 100000;
  for (uint64_t k = 0; k < kCount; ++k) {
    const double x = random.uniform(k);
    ASSERT_GE(x, 0);
    ASSERT_LT(x, 1);
    sum += x;
    sum2 += x * x;
  }
  EXPECT_NEAR(sum / kCount, 0.5, 5 * std::sqrt(1 / 12.0 / kCount));
  EXPECT_NEAR(sum2 / kCount, 1 / 3.0, 0.005);
  EXPECT_EQ(random.bits(17), CounterRandom(kSeed).bits(17));
  EXPECT_NE(random.bits(17), other.bits(17));
}

}  // namespace
}  // namespace multireach
