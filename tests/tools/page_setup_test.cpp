#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "runtime/rig_config.hpp"
#include "tools/page/setup_text.hpp"

namespace multireach {
namespace {

TEST(PageSetup, DescribesTheArmAndItsCameras) {
  const std::string folder = std::string(MULTIREACH_SOURCE_DIR) + "/robots/hoap2";
  const RigConfig rig = load_rig(Config::load(folder + "/vision.yaml").section("cameras"));
  const auto text = nlohmann::json::parse(setup_text(RobotConfig::load(folder), &rig.rig));
  const auto& setup = text.at("setup");
  EXPECT_EQ(setup["robot"], "hoap2");
  EXPECT_EQ(setup["base"], "torso");
  EXPECT_EQ(setup["tip"], "right_hand");
  EXPECT_NE(setup["urdf"].get<std::string>().find("<robot name=\"hoap2\">"), std::string::npos);
  ASSERT_EQ(setup["joints"].size(), 4U);
  EXPECT_EQ(setup["joints"][0]["name"], "right_SFE");
  EXPECT_EQ(setup["joints"][0]["velocity"], 6.0);
  EXPECT_EQ(setup["joints"][0]["acceleration"], 60.0);
  ASSERT_EQ(setup["cameras"].size(), 2U);
  // The positions that vision.yaml gives for the left camera, and the baseline between both.
  const auto& left = setup["cameras"][0]["X_WC"];
  const auto& right = setup["cameras"][1]["X_WC"];
  EXPECT_EQ(left[3], -0.15);
  EXPECT_EQ(left[7], -0.07);
  EXPECT_EQ(left[11], 0.45);
  double squared = 0;
  for (const int i : {3, 7, 11}) squared += std::pow(left[i].get<double>() - right[i].get<double>(), 2);
  EXPECT_NEAR(std::sqrt(squared), rig.rig.baseline_m(), 1e-12);
}

TEST(PageSetup, WritesUnlimitedAsNull) {
  const Joint joint{.name = "turn",
                    .type = Joint::Type::kContinuous,
                    .lower = -Config::kInfinity,
                    .upper = Config::kInfinity,
                    .velocity = Config::kInfinity};
  RobotConfig robot = RobotConfig::load(std::string(MULTIREACH_SOURCE_DIR) + "/robots/hoap2");
  robot.chain = Chain({joint}, {Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()}, "base", "tip");
  robot.joint_acceleration_limits = {};
  const auto text = nlohmann::json::parse(setup_text(robot, nullptr));
  for (const char* limit : {"lower", "upper", "velocity", "acceleration"})
    EXPECT_TRUE(text.at("setup")["joints"][0][limit].is_null()) << limit;
  EXPECT_TRUE(text["setup"]["cameras"].empty());
}

}  // namespace
}  // namespace multireach
