#include "runtime/command_filter.hpp"

#include <gtest/gtest.h>

namespace multireach {
namespace {

constexpr int64_t kRobot = 5, kMillisecond = 1000;

joint_command_t command(int64_t bridge, int64_t robot = kRobot) {
  joint_command_t message{};
  message.run = bridge;
  message.robot_run = robot;
  return message;
}

TEST(CommandFilter, ObeysOneBridgeUntilItIsSilentForATenthOfASecond) {
  CommandFilter filter;
  EXPECT_TRUE(filter.accepts(command(1), kRobot, 0));
  EXPECT_FALSE(filter.accepts(command(2), kRobot, 99 * kMillisecond));
  EXPECT_TRUE(filter.accepts(command(1), kRobot, 99 * kMillisecond));
  EXPECT_FALSE(filter.accepts(command(2), kRobot, 198 * kMillisecond));
  EXPECT_STREQ(filter.refusal(), "refused commands of another bridge");
  EXPECT_TRUE(filter.accepts(command(2), kRobot, 199 * kMillisecond)) << "a bridge that was started again";
  EXPECT_EQ(filter.bridge_run(), 2);
  EXPECT_FALSE(filter.accepts(command(2, 6), kRobot, 200 * kMillisecond)) << "for another robot";
}

}  // namespace
}  // namespace multireach
