#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "controller/node/controller_node.hpp"
#include "robot_bridge/node/bridge_node.hpp"
#include "robot_bridge/sim/robot_sim_node.hpp"
#include "runtime/channel_table.hpp"
#include "runtime/message_schema.hpp"
#include "tools/view/picture_node.hpp"
#include "tools/view/view_node.hpp"
#include "vision/node/vision_node.hpp"

namespace multireach::channel {
namespace {

/// The entries of a list as "bridge, view".
std::set<std::string> entries_of(std::string_view list) {
  std::istringstream stream{std::string(list)};
  std::set<std::string> entries;
  for (std::string entry; std::getline(stream >> std::ws, entry, ',');) entries.insert(entry);
  return entries;
}

TEST(ChannelTable, HasTheChannelsInTheirOrderWithTypesThatExist) {
  ASSERT_EQ(kChannels.size(), kAll.size());
  std::set<std::string_view> types;
  for (const MessageSchema* schema : MessageSchemas::project().all()) types.insert(schema->name);
  for (size_t i = 0; i < kAll.size(); ++i) {
    EXPECT_EQ(kChannels[i].name, kAll[i]);
    EXPECT_TRUE(types.contains(kChannels[i].type)) << kChannels[i].type;
  }
}

TEST(ChannelTable, NamesWhatEachNodeTakes) {
  const RobotConfig robot = RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml");
  const VisionNode vision(VisionConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml"));
  const ControllerNode controller(robot);
  const BridgeNode bridge(robot);
  const RobotSimNode robot_sim(robot);
  const ViewNode view(robot, {});
  const PictureNode picture("", 0);
  std::map<std::string, std::set<std::string_view>> taken;
  for (const Node* node :
       std::initializer_list<const Node*>{&vision, &controller, &bridge, &robot_sim, &view, &picture})
    for (const std::string_view channel : node->inputs()) taken[node->name()].insert(channel);
  taken["robot-sim"] = taken.extract("robot_sim").mapped();
  // All nodes that a replay steps hear of it without naming it.
  for (const char* node : {"vision", "controller", "bridge", "robot-sim"}) taken[node].insert(kReplayStep);
  for (const auto& [node, channels] : taken) {
    for (const Channel& channel : kChannels)
      EXPECT_EQ(entries_of(channel.receivers).contains(node), channels.contains(channel.name))
          << node << " and " << channel.name;
  }
}

TEST(ChannelTable, NamesThePublishers) {
  for (const Publisher& publisher : kPublishers) {
    const std::string program = publisher.node == "robot_sim"     ? "robot-sim"
                                : publisher.node == "ideal_robot" ? "replay"
                                                                  : std::string(publisher.node);
    for (const Channel& channel : kChannels) {
      if (std::ranges::find(publisher.channels, channel.name) == publisher.channels.end()) continue;
      EXPECT_TRUE(entries_of(channel.senders).contains(program)) << program << " and " << channel.name;
    }
  }
}

TEST(ImageUrl, IsOnePortAboveTheControlGroup) {
  EXPECT_EQ(image_url_for(kControlUrl), kImageUrl) << "the default groups";
  EXPECT_EQ(image_url_for("udpm://239.1.2.3:5000?ttl=1"), "udpm://239.1.2.3:5001?ttl=1");
  EXPECT_EQ(image_url_for("udpm://239.1.2.3:5000"), "udpm://239.1.2.3:5001");
  EXPECT_EQ(image_url_for("udpm://239.1.2.3"), "udpm://239.1.2.3:7668") << "LCM's default port";
  EXPECT_EQ(image_url_for("udpm://?ttl=1"), "udpm://239.255.76.67:7668?ttl=1") << "LCM's default group";
  EXPECT_EQ(image_url_for("tcpq://localhost:7700"), "tcpq://localhost:7700") << "one server carries both";
}

}  // namespace
}  // namespace multireach::channel
