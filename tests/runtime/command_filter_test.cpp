#include "runtime/command_filter.hpp"

#include <gtest/gtest.h>

namespace multireach {
namespace {

constexpr int64_t kRobot = 5, kMillisecond = 1000;

/// Each is newer than the one before.
joint_command_t command(int64_t bridge, int64_t robot = kRobot) {
  static int64_t sequence = 0;
  joint_command_t message{};
  message.sequence = sequence++;
  message.run = bridge;
  message.robot_run = robot;
  return message;
}

/// Whether the robot obeys.
bool accepts(CommandFilter& filter, const joint_command_t& message, int64_t now_us) {
  if (filter.refusal_of(message, kRobot, now_us)) return false;
  filter.obey(message, now_us);
  return true;
}

TEST(CommandFilter, ObeysOneBridgeUntilItIsSilentForATenthOfASecond) {
  CommandFilter filter;
  EXPECT_TRUE(accepts(filter, command(1), 0));
  EXPECT_FALSE(accepts(filter, command(2), 99 * kMillisecond));
  EXPECT_TRUE(accepts(filter, command(1), 99 * kMillisecond));
  EXPECT_FALSE(accepts(filter, command(2), 198 * kMillisecond));
  EXPECT_STREQ(filter.refusal_of(command(2), kRobot, 198 * kMillisecond), "refused commands of another bridge");
  EXPECT_TRUE(accepts(filter, command(2), 199 * kMillisecond)) << "a bridge that was started again";
  EXPECT_EQ(filter.bridge_run(), 2);
  EXPECT_FALSE(accepts(filter, command(2, 6), 200 * kMillisecond)) << "for another robot";
}

TEST(CommandFilter, ACommandThatTheRobotRefusesOwnsNothing) {
  CommandFilter filter;
  EXPECT_EQ(filter.refusal_of(command(1), kRobot, 0), nullptr);
  EXPECT_TRUE(accepts(filter, command(2), kMillisecond)) << "bridge 1 was not obeyed";
  EXPECT_EQ(filter.bridge_run(), 2);
}

TEST(CommandFilter, TheFirstCommandOfRunZeroIsObeyed) {
  CommandFilter filter;
  EXPECT_EQ(filter.sequence(), -1);
  joint_command_t first{};
  first.robot_run = kRobot;
  EXPECT_TRUE(accepts(filter, first, 0)) << "a sender without a number of its own";
  EXPECT_EQ(filter.sequence(), 0);
}

TEST(CommandFilter, ALateOrRepeatedCommandIsRefused) {
  CommandFilter filter;
  const joint_command_t first = command(1), second = command(1);
  EXPECT_TRUE(accepts(filter, first, 0));
  EXPECT_TRUE(accepts(filter, second, kMillisecond));
  EXPECT_STREQ(filter.refusal_of(second, kRobot, kMillisecond), "refused commands that came late or twice");
  EXPECT_STREQ(filter.refusal_of(first, kRobot, 80 * kMillisecond), "refused commands that came late or twice");
  joint_command_t restarted = first;
  restarted.run = 2;
  EXPECT_TRUE(accepts(filter, restarted, 200 * kMillisecond)) << "a bridge that was started again begins at 0";
}

}  // namespace
}  // namespace multireach
