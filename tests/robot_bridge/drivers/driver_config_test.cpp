// The section `driver` of robot.yaml.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "robot_bridge/drivers/node/driver_config.hpp"
#include "tests/input_fault.hpp"
#include "tests/robot_bridge/drivers/driver_loop.hpp"
#include "tests/temporary_folder.hpp"

namespace multireach::testing {
namespace {

TEST(DriverConfig, NamesWhatIsWrong) {
  const RobotConfig hoap2 = robot_named("hoap2"), iiwa = robot_named("iiwa14");
  EXPECT_NE(input_fault([&] { (void)drivers::driver_config_from(hoap2, ""); }).find("no driver is named"),
            std::string::npos);
  EXPECT_NE(input_fault([&] { (void)drivers::driver_config_from(iiwa, "ur"); }).find("is that of the driver 'iiwa'"),
            std::string::npos);
  drivers::DriverConfig unknown;
  unknown.name = "nonesuch";
  EXPECT_NE(input_fault([&] { (void)drivers::make_driver(iiwa, unknown); }).find("'nonesuch' is no driver"),
            std::string::npos);
  EXPECT_EQ(drivers::driver_config_from(iiwa, "").name, "iiwa");
  EXPECT_NE(input_fault([&] { (void)drivers::driver_config_from(hoap2, "template"); }).find("'driver.port' is missing"),
            std::string::npos);
}

// A start position in degrees, and two motors of one id.
TEST(DriverConfig, RefusesAStartBeyondTheLimitsAndAnIdThatStandsTwice) {
  RobotConfig robot = robot_named("ur5e");
  robot.start["elbow_joint"] = 90;
  EXPECT_NE(input_fault([&] {
              (void)drivers::make_emulator(robot, drivers::driver_config_from(robot, ""));
            }).find("key 'start_joint_position.elbow_joint' is 90; expected -3.14159 to 3.14159"),
            std::string::npos);

  const testing::TemporaryFolder folder;
  std::filesystem::copy(MULTIREACH_SOURCE_DIR "/robots/so101/so101.urdf", folder / "so101.urdf");
  std::ifstream in(MULTIREACH_SOURCE_DIR "/robots/so101/robot.yaml");
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const auto at = text.find("[1, 2, 3, 4, 5]");
  ASSERT_NE(at, std::string::npos);
  std::ofstream(folder / "robot.yaml") << text.replace(at, 15, "[1, 2, 3, 2, 5]");
  EXPECT_NE(input_fault([&] {
              (void)drivers::driver_config_from(RobotConfig::load(folder / "robot.yaml"), "");
            }).find("'driver.motor_ids' expected another number for each joint"),
            std::string::npos);
}

}  // namespace
}  // namespace multireach::testing
