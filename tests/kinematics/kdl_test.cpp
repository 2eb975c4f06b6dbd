// Compares forward kinematics and Jacobian with Orocos KDL.
#include <gtest/gtest.h>

#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "tests/kinematics/kdl_chain.hpp"
#include "tests/test_arms.hpp"

namespace multireach {
namespace {

constexpr uint64_t kSeed = 31337;

TEST(AgainstKdl, PoseAndJacobianAgreeTo1e12) {
  const auto files = testing::all_arm_files();
  if (files.size() == 1) std::cout << "skipped: the arms of shared/robots, which is not here\n";
  for (const testing::ArmFile& file : files) {
    const Chain chain = testing::load(file);
    const KDL::Chain kdl = testing::kdl_chain(testing::file_text(file.path), file.base, file.tip);
    ASSERT_EQ(static_cast<int>(kdl.getNrOfJoints()), chain.size());
    KDL::ChainFkSolverPos_recursive position(kdl);
    KDL::ChainJntToJacSolver derivative(kdl);
    const CounterRandom random(kSeed);
    double worst = 0;
    for (uint64_t k = 0; k < 200; ++k) {
      const JointVector theta = testing::random_posture(chain, random, k);
      KDL::JntArray q(theta.size());
      q.data = theta;
      KDL::Frame frame;
      KDL::Jacobian jacobian(theta.size());
      position.JntToCart(q, frame);
      derivative.JntToJac(q, jacobian);
      Eigen::Isometry3d X_WT;
      PoseJacobian ours;
      chain.pose_and_jacobian(theta, X_WT, ours);
      for (int row = 0; row < 3; ++row) {
        worst = std::max(worst, std::abs(frame.p(row) - X_WT.translation()[row]));
        for (int column = 0; column < 3; ++column)
          worst = std::max(worst, std::abs(frame.M(row, column) - X_WT.linear()(row, column)));
      }
      worst = std::max(worst, (jacobian.data - ours).cwiseAbs().maxCoeff());
    }
    EXPECT_LT(worst, 1e-12) << file.path << ", seed " << kSeed;
  }
}

}  // namespace
}  // namespace multireach
