#include "controller/law/paper_equations.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 28;

TEST(LimitWeights, FollowEquation28InsideAndVanishOutside) {
  const Chain chain = testing::hoap2();
  constexpr double kGamma = 350;
  JointVector theta = 0.5 * (chain.lower() + chain.upper());
  EXPECT_TRUE(limit_weights(chain, theta, kGamma).isApprox(JointVector::Constant(4, kGamma), 1e-12))
      << "gamma in the middle";
  theta = 0.75 * chain.lower() + 0.25 * chain.upper();
  EXPECT_TRUE(limit_weights(chain, theta, kGamma).isApprox(JointVector::Constant(4, kGamma / 2), 1e-12))
      << "half of it at a quarter";
  EXPECT_EQ(limit_weights(chain, chain.lower(), kGamma).norm(), 0);
  EXPECT_EQ(limit_weights(chain, chain.upper(), kGamma).norm(), 0);
  const JointVector beyond = chain.upper() + 0.5 * (chain.upper() - chain.lower());
  EXPECT_EQ(limit_weights(chain, beyond, kGamma).norm(), 0) << "the cosine alone would give gamma here";
}

TEST(LimitWeights, AreGammaForAContinuousJoint) {
  const Chain chain = chain_from_urdf(
      "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='continuous'><parent link='a'/><child "
      "link='b'/>"
      "<axis xyz='0 0 1'/></joint></robot>",
      "a", "b");
  JointVector theta(1);
  theta << 77;
  EXPECT_EQ(limit_weights(chain, theta, 5)[0], 5);
}

struct Case {
  PositionJacobian J;
  JointVector weights, joint_velocity;
  Eigen::Vector3d hand_velocity;
};

Case random_case(const Chain& chain, uint64_t k) {
  const CounterRandom random(kSeed);
  const JointVector theta = testing::random_posture(chain, random, k, 0.02);
  Case c;
  Eigen::Vector3d x;
  chain.position_and_jacobian(theta, x, c.J);
  c.weights = limit_weights(chain, theta, 350);
  c.joint_velocity = testing::random_posture(chain, random, k + 1000) * 0.01;
  c.hand_velocity = Eigen::Vector3d(random.uniform(k + 77), random.uniform(k + 78), random.uniform(k + 79)) * 0.01;
  return c;
}

TEST(CoherentVelocity, TheTwoFormsOfThePaperAgree) {
  // Compares Eq. (13), which inverts an n x n matrix that contains the weights, with Eq. (14), which is implemented.
  for (const auto& file : testing::all_arm_files()) {
    const Chain chain = testing::load(file);
    for (uint64_t k = 0; k < 100; ++k) {
      const Case c = random_case(chain, k);
      const Eigen::MatrixXd W_theta = c.weights.cwiseInverse().asDiagonal();
      const Eigen::VectorXd expected = (W_theta + c.J.transpose() * c.J).inverse() *
                                       (W_theta * c.joint_velocity + c.J.transpose() * c.hand_velocity);
      const JointVector actual = coherent_velocity(c.J, c.weights, c.joint_velocity, c.hand_velocity);
      EXPECT_LT((actual - expected).norm(), 1e-11) << file.path << ", seed " << kSeed << ", case " << k;
    }
  }
}

TEST(CoherentVelocity, NoOtherVelocityIsCheaper) {
  const Chain chain = testing::hoap2();
  const CounterRandom random(kSeed, 5);
  const auto cost = [](const Case& c, const JointVector& v) {
    return (v - c.joint_velocity).cwiseAbs2().cwiseQuotient(c.weights).sum() +
           (c.J * v - c.hand_velocity).squaredNorm();
  };
  for (uint64_t k = 0; k < 200; ++k) {
    const Case c = random_case(chain, k);
    const JointVector best = coherent_velocity(c.J, c.weights, c.joint_velocity, c.hand_velocity);
    JointVector other = best;
    for (int i = 0; i < 4; ++i) other[i] += random.uniform(4 * k + static_cast<uint64_t>(i), -1e-3, 1e-3);
    EXPECT_LT(cost(c, best), cost(c, other)) << "seed " << kSeed << ", case " << k;
  }
}

TEST(CoherentVelocity, WithoutWeightTheJointsFollowTheirOwnAttractor) {
  Case c = random_case(testing::hoap2(), 3);
  c.weights.setZero();
  EXPECT_EQ(coherent_velocity(c.J, c.weights, c.joint_velocity, c.hand_velocity), c.joint_velocity);
}

TEST(ConditionNumber, StaysBelowTheBoundOfEquation32) {
  const Chain chain = testing::hoap2();
  const CounterRandom random(kSeed);
  constexpr double kGamma = 350, kSigma2 = 0.217 * 0.217 + 0.101 * 0.101;  // largest singular value, stretched arm
  for (uint64_t k = 0; k < 2000; ++k) {
    const JointVector theta = testing::random_posture(chain, random, k);
    Eigen::Vector3d x;
    PositionJacobian J;
    chain.position_and_jacobian(theta, x, J);
    const double condition = condition_number(coherence_matrix(J, limit_weights(chain, theta, kGamma)));
    EXPECT_GE(condition, 1);
    EXPECT_LE(condition, 1 + kGamma * kSigma2) << "seed " << kSeed << ", posture " << k;
  }
}

}  // namespace
}  // namespace multireach::controller
