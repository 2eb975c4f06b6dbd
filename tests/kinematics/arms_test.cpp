// The arms of robots/ against public descriptions of the same arms.
#include <gtest/gtest.h>

#include <numbers>

#include "tests/test_arms.hpp"

namespace multireach::testing {
namespace {

struct Twin {
  const char* name;
  ArmFile ours, theirs;
  bool same_tip_frame;  // else only the tips' positions agree
};

class Arms : public ::testing::TestWithParam<Twin> {};

TEST_P(Arms, AgreeWithThePublicDescription) {
  const Twin& twin = GetParam();
  if (!std::filesystem::exists(twin.theirs.path)) GTEST_SKIP() << twin.theirs.path << " is not here";
  const Chain ours = load(twin.ours), theirs = load(twin.theirs);
  ASSERT_EQ(ours.size(), theirs.size());
  const CounterRandom random(17);
  for (uint64_t k = 0; k < 200; ++k) {
    SCOPED_TRACE("seed 17, posture " + std::to_string(k));
    const JointVector theta = random_posture(ours, random, k);
    const Eigen::Isometry3d X = ours.pose(theta), Y = theirs.pose(theta);
    ASSERT_LT((X.translation() - Y.translation()).norm(), 1e-9);
    if (twin.same_tip_frame) {
      ASSERT_LT((X.linear() - Y.linear()).norm(), 1e-9);
    }
  }
  for (int i = 0; i < ours.size(); ++i) {
    EXPECT_LE(ours.upper()[i], theirs.upper()[i] + 1e-4) << ours.joint(i).name;
    EXPECT_GE(ours.lower()[i], theirs.lower()[i] - 1e-4) << ours.joint(i).name;
    EXPECT_LE(ours.velocity()[i], theirs.velocity()[i] + 1e-4) << ours.joint(i).name;
  }
}

// Franka's table of Denavit-Hartenberg parameters (Craig's convention), which its two models share: a, d, alpha.
Eigen::Isometry3d franka_flange(const JointVector& theta) {
  constexpr double kTurn = std::numbers::pi / 2;
  constexpr double kTable[][3] = {
      {0, 0.333, 0}, {0, 0, -kTurn},    {0, 0.316, kTurn}, {0.0825, 0, kTurn}, {-0.0825, 0.384, -kTurn},
      {0, 0, kTurn}, {0.088, 0, kTurn}, {0, 0.107, 0}};
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 8; ++i) {
    const auto& [a, d, alpha] = kTable[i];
    X = X * Eigen::AngleAxisd(alpha, Eigen::Vector3d::UnitX()) * Eigen::Translation3d(a, 0, 0) *
        Eigen::AngleAxisd(i < 7 ? theta[i] : 0, Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(0, 0, d);
  }
  return X;
}

TEST(ArmsOfTheProject, FrankasAgreeWithTheTableOfDenavitAndHartenberg) {
  for (const std::string name : {"panda", "fr3"}) {
    const Chain chain =
        load({MULTIREACH_SOURCE_DIR "/robots/" + name + "/" + name + ".urdf", name + "_link0", name + "_link8"});
    const CounterRandom random(18);
    for (uint64_t k = 0; k < 200; ++k) {
      const JointVector theta = random_posture(chain, random, k);
      ASSERT_LT((chain.pose(theta).matrix() - franka_flange(theta).matrix()).norm(), 1e-9) << name << " seed 18, " << k;
    }
  }
}

TEST(ArmsOfTheProject, AChangedLengthIsFound) {
  const ArmFile file{MULTIREACH_SOURCE_DIR "/robots/panda/panda.urdf", "panda_link0", "panda_hand"};
  std::string text = file_text(file.path);
  const auto at = text.find("0.316");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 5, "0.317");
  const Chain changed = chain_from_urdf(text, file.base, file.tip);
  const JointVector theta = JointVector::Constant(7, -0.3);
  EXPECT_GT((changed.position(theta) - load(file).position(theta)).norm(), 0.9e-3);
}

ArmFile ours(const std::string& name, const std::string& base, const std::string& tip) {
  return {MULTIREACH_SOURCE_DIR "/robots/" + name + "/" + name + ".urdf", base, tip};
}
ArmFile theirs(const std::string& file, const std::string& base, const std::string& tip) {
  return {MULTIREACH_SHARED_DIR "/robots/" + file, base, tip};
}

INSTANTIATE_TEST_SUITE_P(Twins, Arms,
                         ::testing::Values(Twin{"iiwa14", ours("iiwa14", "base", "iiwa_link_ee"),
                                                theirs("iiwa14.urdf", "base", "iiwa_link_ee"), true},
                                           Twin{"panda", ours("panda", "panda_link0", "panda_hand"),
                                                theirs("panda.urdf", "panda_link0", "panda_hand"), true},
                                           Twin{"ur5", ours("ur5", "base_link", "tool0"),
                                                theirs("ur5_robot.urdf", "base_link", "ee_link"), false}),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace multireach::testing
