// docs/configuration.md is what the programs print of the keys that they read.
#include <gtest/gtest.h>

#include "camera/devices/device_options.hpp"
#include "camera/node/render_source.hpp"
#include "controller/node/controller_config.hpp"
#include "controller/node/controller_node.hpp"
#include "robot_bridge/drivers/node/driver_config.hpp"
#include "robot_bridge/node/bridge_node.hpp"
#include "robot_bridge/sim/robot_sim_node.hpp"
#include "runtime/message_gate.hpp"
#include "vision/node/vision_config.hpp"

namespace multireach {
namespace {

TEST(ConfigReference, IsThePageInTheDocs) {
  const std::string printed =
      robot_config_reference() + "\n" + controller_config_reference() + "\n" + bridge_config_reference() + "\n" +
      robot_sim_config_reference() + "\n" + drivers::driver_config_reference() + "\n" + vision_config_reference() +
      "\n" + RenderSource::config_reference() + "\n" + device_config_reference() + "\n" + key_policy_reference();
  const std::string page = read_text_file(MULTIREACH_SOURCE_DIR "/docs/configuration.md");
  const size_t begin = page.find("## ");
  ASSERT_NE(begin, std::string::npos);
  EXPECT_EQ(page.substr(begin), printed) << "run tools/reference_pages.sh";
}

TEST(ConfigReference, NamesConditionsAndRefusesAKeyWithoutThem) {
  struct Options {
    bool round = true;
    double radius = 0.5;
    int64_t period_us = 250000;
  };
  ConfigKeys<Options> keys("shape", "A shape.");
  keys.flag(
          "round", [](auto& o) -> auto& { return o.round; }, "Whether it is round.")
      .number(
          "period_s", "s", 0, 1, [](auto& o) -> auto& { return o.period_us; }, "How often.", 1e6)
      .only("with round: true", [](const Options& o) { return o.round; })
      .number(
          "radius_m", "m", 0, 2, [](auto& o) -> auto& { return o.radius; }, "Its radius.");
  EXPECT_EQ(keys.reference(),
            "## shape\n\nA shape.\n\n| key | value | unit | default | meaning |\n|---|---|---|---|---|\n"
            "| `round` | true or false |  | true | Whether it is round. |\n"
            "| `period_s` | number from 0 to 1 | s | 0.25 | How often. |\n"
            "| `radius_m` | number from 0 to 2 | m | 0.5 | Its radius. Only with round: true. |\n");
  Options options;
  keys.read(Config::parse("f", "{period_s: 0.5, radius_m: 1}"), options);
  EXPECT_EQ(options.period_us, 500000);
  EXPECT_EQ(options.radius, 1);
  try {
    keys.read(Config::parse("f", "{round: false, radius_m: 1}"), options);
    ADD_FAILURE() << "a key without its condition was accepted";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "f:1: key 'radius_m' is allowed only with round: true");
  }
}

}  // namespace
}  // namespace multireach
