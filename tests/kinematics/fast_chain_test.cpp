#include "kinematics/fast_chain.hpp"

#include <gtest/gtest.h>

#include "tests/test_arms.hpp"

namespace multireach {
namespace {

constexpr uint64_t kSeed = 71;

TEST(SineAndCosine, AgreeWithTheLibraryInEveryQuadrantAndFarOut) {
  for (const double from : {-4.0, 3.0, -1e5, 9.99e4}) {
    for (int k = 0; k < 100000; ++k) {
      const double angle = from + k * 8e-5;
      Double2 sine, cosine;
      sine_and_cosine(Double2{angle, -angle}, sine, cosine);
      ASSERT_NEAR(sine[0], std::sin(angle), 1e-15) << angle;
      ASSERT_NEAR(cosine[1], std::cos(angle), 1e-15) << angle;
      double s = 0, c = 0;
      sine_and_cosine(angle, s, c);
      ASSERT_EQ(s, sine[0]) << "a lane has the bits of a plain double";
      ASSERT_EQ(c, cosine[0]);
    }
  }
}

template <int N>
void agrees_with_chain(const Chain& chain, const std::string& name) {
  const FastChain<N, Double2> fast(chain);
  const CounterRandom random(kSeed);
  for (uint64_t k = 0; k < 300; ++k) {
    const JointVector first = testing::random_posture(chain, random, 2 * k),
                      second = testing::random_posture(chain, random, 2 * k + 1);
    typename FastChain<N, Double2>::PerJoint theta;
    for (int i = 0; i < chain.size(); ++i) theta[static_cast<size_t>(i)] = Double2{first[i], second[i]};
    typename FastChain<N, Double2>::Hand hand;
    fast.template forward_kinematics<true>(theta, hand);
    for (int lane = 0; lane < 2; ++lane) {
      Eigen::Isometry3d X_WT;
      PoseJacobian jacobian;
      chain.pose_and_jacobian(lane ? second : first, X_WT, jacobian);
      for (size_t row = 0; row < 3; ++row) {
        const auto r = static_cast<Eigen::Index>(row);
        ASSERT_NEAR(hand.position[row][lane], X_WT.translation()[r], 1e-12) << name << ", seed " << kSeed;
        for (size_t c = 0; c < 3; ++c) {
          ASSERT_NEAR(hand.rotation[c][row][lane], X_WT.linear()(r, static_cast<Eigen::Index>(c)), 1e-12) << name;
        }
      }
      for (size_t row = 0; row < 6; ++row) {
        for (int i = 0; i < chain.size(); ++i) {
          ASSERT_NEAR(hand.jacobian[row][static_cast<size_t>(i)][lane], jacobian(static_cast<Eigen::Index>(row), i),
                      1e-12)
              << name << ", row " << row << ", joint " << i;
        }
      }
    }
  }
}

TEST(FastChain, AgreesWithChainOnEveryArm) {
  for (const testing::ArmFile& file : testing::all_arm_files()) agrees_with_chain<0>(testing::load(file), file.path);
  agrees_with_chain<4>(testing::hoap2(), "hoap2");
}

TEST(FastChain, AgreesWithChainOnOddArms) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    agrees_with_chain<0>(testing::odd_arm(2 + static_cast<int>(seed % 8), seed), "odd arm " + std::to_string(seed));
    agrees_with_chain<6>(testing::odd_arm(6, seed), "odd arm " + std::to_string(seed));
  }
}

TEST(FastChain, AxesThatAreNearlyParallelDoNoHarm) {
  // Such axes occur in URDFs whose right angles are rounded.
  const Chain arm = testing::odd_arm(5, 3, false);
  for (const double tilt : {0.0, 1e-17, 1e-13, 3.7e-6, M_PI / 2 + 3.7e-6, M_PI - 1e-9}) {
    std::vector<Eigen::Isometry3d> fixed;
    std::vector<Joint> joints = arm.joints();
    for (int i = 0; i <= arm.size(); ++i) {
      fixed.push_back(arm.fixed(i));
      fixed.back().linear() = Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()).toRotationMatrix();
    }
    for (Joint& joint : joints) joint.axis = Eigen::Vector3d::UnitZ();
    agrees_with_chain<5>(Chain(joints, fixed, "base", "hand"), "tilt " + std::to_string(tilt));
  }
}

}  // namespace
}  // namespace multireach
