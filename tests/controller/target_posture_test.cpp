#include "controller/law/paper_equations.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "tests/test_arms.hpp"

namespace multireach::controller {
namespace {

constexpr uint64_t kSeed = 27;

TEST(TargetPosture, SolvesTheProblemOfEquations15And16) {
  // Solve the KKT system of: minimise |theta_T + d - theta|^2 subject to J_T d = x_T' + x_T - K(theta_T).
  for (const auto& file : testing::all_arm_files()) {
    const Chain chain = testing::load(file);
    const CounterRandom random(kSeed);
    const int n = chain.size();
    for (uint64_t k = 0; k < 100; ++k) {
      const JointVector theta = testing::random_posture(chain, random, 2 * k),
                        theta_T = testing::random_posture(chain, random, 2 * k + 1);
      const Eigen::Vector3d velocity(0.001, -0.002, 0.0005);
      Eigen::Vector3d reached;
      PositionJacobian J;
      chain.position_and_jacobian(theta_T, reached, J);
      if (std::abs((J * J.transpose()).determinant()) < 1e-8) continue;
      const Eigen::Vector3d x_T = reached + Eigen::Vector3d(0.003, 0.001, -0.002);
      Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(n + 3, n + 3);
      kkt.topLeftCorner(n, n).setIdentity();
      kkt.topRightCorner(n, 3) = J.transpose();
      kkt.bottomLeftCorner(3, n) = J;
      Eigen::VectorXd right(n + 3);
      right << theta - theta_T, velocity + x_T - reached;
      const Eigen::VectorXd expected = theta_T + kkt.fullPivLu().solve(right).head(n);
      const JointVector actual = updated_target_posture(chain, theta_T, theta, x_T, velocity);
      EXPECT_LT((actual - expected).norm(), 1e-8 * (1 + expected.norm()))
          << file.path << ", seed " << kSeed << ", case " << k;
    }
  }
}

TEST(TargetPosture, StaysWhereItIsWhenNothingIsNearer) {
  const Chain chain = testing::hoap2();
  const CounterRandom random(kSeed);
  const JointVector theta = testing::random_posture(chain, random, 4, 0.1);
  const JointVector updated =
      updated_target_posture(chain, theta, theta, chain.position(theta), Eigen::Vector3d::Zero());
  EXPECT_LT((updated - theta).norm(), 1e-12);
}

}  // namespace
}  // namespace multireach::controller
