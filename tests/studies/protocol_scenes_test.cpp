#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <numbers>

#include "studies/figures/scenes.hpp"
#include "tests/test_arms.hpp"

namespace multireach {
namespace {

/// What rounding may leave of a number of about 1: at most a thousand operations.
constexpr double kRounding = 1000 * std::numeric_limits<double>::epsilon();

/// Quantities by law and name.
using Quantities = std::map<std::string, std::map<std::string, double>>;
Quantities quantities_of(const Figure& figure) {
  Quantities quantities;
  for (const Measure& measure : figure.measures) quantities[measure.law][measure.quantity] = measure.value;
  return quantities;
}

bool is_of_a_protocol(const testing::ArmFile& file) {
  return file.tip == "right_hand" || file.tip == "panda_hand" || file.tip == "iiwa_link_ee";
}

TEST(ProtocolScenes, TheDefaultLawArrivesInsideTheLimitsInOneStroke) {
  for (const auto& file : testing::all_arm_files()) {
    if (!is_of_a_protocol(file)) continue;
    Quantities of = quantities_of(protocol_reaches_scene({.chain = testing::load(file), .urdf_xml = {}}));
    ASSERT_TRUE(of.contains("guarded") && of.contains("minimum jerk; 1.5 s")) << file.path;
    auto &guarded = of["guarded"], &ideal = of["minimum jerk; 1.5 s"];
    EXPECT_EQ(guarded.at("reaches"), 20) << file.path;
    // After 9 s, 1260 steps, the attractor's double pole at 1 - alpha / 2 leaves 51 * 0.96^1260 of the distance, and
    // theta_T has converged too, quadratically. What remains is rounding.
    EXPECT_LT(guarded.at("hand to target at the end; worst"), 1e3 * kRounding * testing::load(file).reach())
        << file.path << ", mm";
    EXPECT_LT(guarded.at("path / distance; worst"), of["paper"].at("path / distance; median"))
        << file.path << ": straighter than the paper's law, as docs/results-protocols.md states";
    EXPECT_EQ(guarded.at("most maxima of the hand speed"), 1) << file.path;
    EXPECT_EQ(guarded.at("farthest beyond a limit"), 0) << file.path;
    EXPECT_LE(guarded.at("largest joint speed / its limit"), 1 + 1e-9) << file.path;
    EXPECT_NEAR(ideal.at("path / distance; worst"), 1, 1e-9) << file.path;
    EXPECT_GT(guarded.at("normalised jerk; median"), ideal.at("normalised jerk; median")) << file.path;
    if (!of.contains("guarded; orientation held")) continue;
    EXPECT_LT(of["guarded; orientation held"].at("hand turned by at most"), kRounding * 180 / std::numbers::pi)
        << file.path << ", degrees";
  }
}

TEST(ProtocolScenes, AnArmThatDoesNotReachThePointsIsRefused) {
  std::vector<Joint> joints = testing::hoap2().joints();
  for (Joint& joint : joints) joint.lower = joint.upper = 0.5 * (joint.lower + joint.upper);
  const Chain arm = testing::hoap2();
  std::vector<Eigen::Isometry3d> fixed;
  for (int i = 0; i <= arm.size(); ++i) fixed.push_back(arm.fixed(i));
  EXPECT_THROW(protocol_reaches_scene({.chain = Chain(joints, fixed, "torso", "right_hand"), .urdf_xml = {}}),
               std::invalid_argument);
}

}  // namespace
}  // namespace multireach
