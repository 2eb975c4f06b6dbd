#include "robot_bridge/sim/mujoco_arm.hpp"

#include <gtest/gtest.h>
#include <spdlog/sinks/ringbuffer_sink.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <filesystem>

#include "tests/temporary_folder.hpp"
#include "tests/test_arms.hpp"

namespace multireach {
namespace {

std::string hoap2_urdf() {
  return testing::file_text(testing::hoap2_file().path);
}

Eigen::Vector3d hand_of(const MujocoArm& arm, const Chain& chain) {
  JointVector theta(chain.size());
  const std::vector<double> positions = arm.positions();
  for (size_t i = 0; i < positions.size(); ++i) {
    const int at = chain.index_of(arm.joint_names()[i]);
    if (at >= 0) theta[at] = positions[i];
  }
  return chain.position(theta);
}

TEST(MujocoArm, HoldsItsPostureAgainstGravity) {
  MujocoArm arm(hoap2_urdf(), {.start = {{"right_SAA", -1.2}, {"right_EB", -0.8}}});
  ASSERT_EQ(arm.joint_names().size(), 8U);
  const std::vector<double> before = arm.positions();
  for (int ms = 0; ms < 1000; ++ms) arm.step();
  for (size_t i = 0; i < before.size(); ++i) EXPECT_NEAR(arm.positions()[i], before[i], 1e-3) << arm.joint_names()[i];
  double effort = 0;
  for (const double torque : arm.torques()) effort += std::abs(torque);
  EXPECT_GT(effort, 0.3) << "N m: it does bear its weight";
}

TEST(MujocoArm, FollowsASmoothCommand) {
  MujocoArm arm(hoap2_urdf(), {.start = {{"right_SFE", 0}, {"right_EB", -1}}});
  double worst = 0;
  for (int ms = 0; ms < 2000; ++ms) {
    const double t = ms * 1e-3, wanted = -1 + 0.5 * std::sin(3 * t), speed = 1.5 * std::cos(3 * t);
    arm.command("right_EB", wanted, speed);
    arm.step();
    const auto& names = arm.joint_names();
    const auto at = static_cast<size_t>(std::find(names.begin(), names.end(), "right_EB") - names.begin());
    if (ms > 200) worst = std::max(worst, std::abs(arm.positions()[at] - wanted));
  }
  EXPECT_LT(worst, 5e-3) << "rad";
}

// Commands that come late are a step that the drives of a large arm cannot follow at once.
TEST(MujocoArm, DoesNotFlingAfterAGapOfItsCommands) {
  constexpr double kSpeed = 2.5, kGap = 0.02, kLimit = 3.14159265;  // rad/s, s, rad/s: of the URDF
  MujocoArm arm(testing::file_text(MULTIREACH_SOURCE_DIR "/robots/ur5e/ur5e.urdf"),
                {.start = {{"shoulder_lift_joint", -1.2}, {"elbow_joint", 1.3}}});
  const std::vector<double> start = arm.positions();
  double fastest = 0, error = 0;
  for (int ms = 0; ms < 3000; ++ms) {
    const double t = ms * 1e-3;
    const bool late = ms >= 1000 && ms % 200 < 1000 * kGap;
    for (size_t i = 0; i < start.size(); ++i) {
      const double phase = 2 * t + static_cast<double>(i), amplitude = kSpeed / 2 * std::min(1.0, t);
      const double wanted = start[i] + amplitude * std::sin(phase);
      if (!late) arm.command(arm.joint_names()[i], wanted, 2 * amplitude * std::cos(phase));
      if (ms >= 1000 && ms % 200 > 180) error = std::max(error, std::abs(arm.positions()[i] - wanted));
    }
    arm.step();
    for (const double speed : arm.velocities()) fastest = std::max(fastest, std::abs(speed));
  }
  EXPECT_LT(fastest, 1.01 * kLimit) << "rad/s; one in a hundred for the integration step";
  EXPECT_GT(fastest, 0.95 * kSpeed) << "rad/s: it does follow";
  EXPECT_LT(error, 5e-3) << "rad: as FollowsASmoothCommand";
}

/// The Hoap2's URDF with this text in each joint.
std::string hoap2_with(const std::string& text) {
  std::string urdf = hoap2_urdf();
  for (size_t at = urdf.find("</joint>"); at != std::string::npos; at = urdf.find("</joint>", at + text.size() + 1))
    urdf.insert(at, text);
  return urdf;
}

TEST(MujocoArm, DrivesCompensateFrictionAndDamping) {
  MujocoArm plain(hoap2_urdf(), {}), stiff(hoap2_with("<dynamics damping='10' friction='1'/>"), {});
  for (int ms = 0; ms < 500; ++ms) {
    for (MujocoArm* arm : {&plain, &stiff}) {
      arm->command("right_EB", -1 - 1e-3 * ms, -1);
      arm->step();
    }
  }
  EXPECT_EQ(stiff.positions(), plain.positions());
}

TEST(MujocoArm, JointsOfAnotherArmDoNotDisturbThisOne) {
  const std::vector<std::string> right{"right_SFE", "right_SAA", "right_SHR", "right_EB"};
  std::string urdf = hoap2_urdf();
  // The left arm is too weak to hold itself.
  for (size_t at = urdf.find("name=\"left_"); at != std::string::npos; at = urdf.find("name=\"left_", at + 1)) {
    const size_t effort = urdf.find("effort=\"", at), end = urdf.find("</joint>", at);
    if (effort < end) urdf.replace(effort, urdf.find('"', effort + 8) + 1 - effort, "effort=\"0.001\"");
  }
  ASSERT_NE(urdf, hoap2_urdf());
  MujocoArm arm(urdf, {.start = {{"right_EB", -1}, {"left_SAA", -0.8}}, .limited = right});
  const auto& names = arm.joint_names();
  const std::vector<double> begin = arm.positions();
  double worst = 0;
  for (int ms = 0; ms < 1000; ++ms) {
    const double wanted = -1 + 0.3 * std::sin(3e-3 * ms);
    arm.command("right_EB", wanted, 0.9 * std::cos(3e-3 * ms));
    arm.step();
    for (size_t i = 0; i < names.size(); ++i) {
      const double expected = names[i] == "right_EB" ? wanted : begin[i];
      if (ms > 200) worst = std::max(worst, std::abs(arm.positions()[i] - expected));
    }
  }
  EXPECT_LT(worst, 5e-3) << "rad: as FollowsASmoothCommand";
}

TEST(MujocoArm, APushMovesItAndItComesBack) {
  const Chain chain = testing::hoap2();
  MujocoArm arm(hoap2_urdf(), {.start = {{"right_SAA", -0.6}, {"right_EB", -1}}});
  const Eigen::Vector3d rest = hand_of(arm, chain);
  EXPECT_FALSE(arm.push("nowhere", {1, 0, 0}));
  EXPECT_FALSE(arm.push("right_hand", {NAN, 0, 0}));
  EXPECT_TRUE(arm.push("right_hand", {20, 0, 0}));
  double farthest = 0;
  for (int ms = 0; ms < 1000; ++ms) {
    if (ms == 100) arm.release();
    arm.step();
    farthest = std::max(farthest, (hand_of(arm, chain) - rest).norm());
  }
  EXPECT_GT(farthest, 2e-3);
  EXPECT_LT((hand_of(arm, chain) - rest).norm(), 5e-4);
}

TEST(MujocoArm, SaysWhatItCannotLoad) {
  EXPECT_THROW(MujocoArm("<robot", {}), std::invalid_argument);
  EXPECT_THROW(MujocoArm("<robot name='r'><link name='a'/></robot>", {}), std::invalid_argument);
  EXPECT_THROW(MujocoArm(hoap2_urdf(), {.start = {{"nose", 1.0}}}), std::invalid_argument);
}

TEST(MujocoArm, NamesTheJointsThatMayHaveAStartPosition) {
  try {
    MujocoArm(hoap2_urdf(), {.start = {{"nose", 1.0}}});
    FAIL() << "there is no joint 'nose'";
  } catch (const std::invalid_argument& fault) {
    EXPECT_NE(std::string(fault.what()).find("no joint 'nose'; it has"), std::string::npos) << fault.what();
    EXPECT_NE(std::string(fault.what()).find("right_SFE, "), std::string::npos) << fault.what();
  }
}

TEST(MujocoArm, StartsInTheMiddleOfLimitsThatExcludeZero) {
  const std::string urdf =
      "<robot name='r'><link name='a'/><link name='b'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' "
      "ixy='0' ixz='0' iyz='0'/></inertial></link><joint name='j' type='revolute'><parent link='a'/><child link='b'/>"
      "<axis xyz='0 0 1'/><limit lower='0.5' upper='2' velocity='1' effort='9'/></joint></robot>";
  EXPECT_EQ(MujocoArm(urdf, {}).positions(), std::vector{1.25});
  EXPECT_EQ(MujocoArm(urdf, {.start = {{"j", 0.75}}}).positions(), std::vector{0.75});
}

TEST(MujocoArm, RefusesMassesAndInertiasThatAreNotPhysical) {
  const auto fault = [](const std::string& mass, const std::string& ixx, const std::string& ixy) -> std::string {
    const std::string inertial = "<inertial><mass value='" + mass + "'/><inertia ixx='" + ixx + "' ixy='" + ixy +
                                 "' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>";
    try {
      MujocoArm("<robot name='r'><link name='a'/><link name='b'>" + inertial +
                    "</link><joint name='j' type='continuous'><parent link='a'/><child link='b'/></joint></robot>",
                {});
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(fault("1", "1", "0"), "");
  EXPECT_EQ(fault("nan", "1", "0"), "link 'b' has a mass that is not a number of 0 or more");
  EXPECT_EQ(fault("-1", "1", "0"), "link 'b' has a mass that is not a number of 0 or more");
  EXPECT_EQ(fault("inf", "1", "0"), "link 'b' has a mass that is not a number of 0 or more");
  EXPECT_EQ(fault("1", "nan", "0"), "link 'b' has an inertia whose 'ixx' is not a finite number");
  EXPECT_EQ(fault("1", "heavy", "0"), "link 'b' has an inertia whose 'ixx' is not a finite number");
  EXPECT_EQ(fault("1", "-1", "0"), "link 'b' has an inertia with a negative principal moment");
  EXPECT_EQ(fault("1", "1", "2"), "link 'b' has an inertia with a negative principal moment") << "1 - 2 < 0";
}

TEST(MujocoArm, ItsWarningsGoToTheLogAndNotIntoTheWorkingFolder) {
  const std::filesystem::path before = std::filesystem::current_path();
  const testing::TemporaryFolder folder;
  std::filesystem::current_path(folder.path());
  auto lines = std::make_shared<spdlog::sinks::ringbuffer_sink_mt>(10);
  const auto previous = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", lines));
  {
    MujocoArm arm(hoap2_urdf(), {});
    std::vector<double> velocities(arm.joint_names().size(), 1e12);
    ASSERT_TRUE(arm.set_state(arm.positions(), velocities));
    for (int ms = 0; ms < 5; ++ms) arm.step();
  }
  spdlog::set_default_logger(previous);
  const bool left_nothing = std::filesystem::is_empty(".");
  std::filesystem::current_path(before);
  EXPECT_TRUE(left_nothing);
  ASSERT_FALSE(lines->last_formatted().empty()) << "these speeds make the simulation diverge";
  EXPECT_NE(lines->last_formatted()[0].find("MuJoCo: "), std::string::npos) << lines->last_formatted()[0];
}

TEST(MujocoArm, LoadsTheSharedArms) {
  const auto files = testing::shared_arm_files();
  if (files.empty()) GTEST_SKIP() << "the arms of shared/robots are not here";
  for (const auto& file : files) {
    MujocoArmOptions options;
    // Stretched out level, Baxter's arm is heavier than its shoulder is strong in the URDF: the real one has springs.
    if (file.path.ends_with("baxter.urdf")) options.start = {{"left_s1", 1.0}, {"right_s1", 1.0}};
    MujocoArm arm(testing::file_text(file.path), options);
    const std::vector<double> before = arm.positions();
    for (int ms = 0; ms < 200; ++ms) arm.step();
    for (size_t i = 0; i < before.size(); ++i)
      EXPECT_NEAR(arm.positions()[i], before[i], 0.02) << file.path << " " << arm.joint_names()[i];
  }
}

}  // namespace
}  // namespace multireach
