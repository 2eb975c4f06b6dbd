// The bundled session is what its recipe says.
#include <gtest/gtest.h>

#include "runtime/channels.hpp"
#include "runtime/log_file.hpp"
#include "tools/camera/camera_node.hpp"
#include "tools/camera/render_source.hpp"

namespace multireach {
namespace {

TEST(ReachSession, IsTheRenderingOfItsScene) {
  LogReader log(MULTIREACH_SOURCE_DIR "/logs/reach.lcm");
  CameraNode camera(std::make_unique<RenderSource>(MULTIREACH_SOURCE_DIR "/logs/reach.yaml"));
  int64_t events = 0, truths = 0;
  Outbox made;
  while (const auto event = log.next()) {
    if (event->channel != channel::kStereoImages && event->channel != channel::kTargetTruth) continue;
    if (made.empty()) camera.tick(made);
    ASSERT_FALSE(made.empty()) << "the log has more events than the scene, at " << events;
    ASSERT_EQ(made.front().channel, event->channel) << events;
    ASSERT_TRUE(std::ranges::equal(made.front().bytes, event->data)) << "event " << events;
    truths += event->channel == channel::kTargetTruth;
    made.erase(made.begin());
    ++events;
  }
  camera.tick(made);
  EXPECT_TRUE(camera.finished()) << "the scene has more frames than the log";
  EXPECT_EQ(events, 2 * truths);
  EXPECT_EQ(log.damaged_bytes(), 0U);
}

}  // namespace
}  // namespace multireach
