// The bundled session is what its recipe says.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <sstream>

#include "camera/node/camera_node.hpp"
#include "camera/node/render_source.hpp"
#include "runtime/channels.hpp"
#include "runtime/log_file.hpp"
#include "tools/replay/run.hpp"

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

/// logs/REPLAY_DIGESTS: what `multireach-replay run` gives for each session, with any compiler, optimisation, sanitizer
/// and number of threads.
TEST(Sessions, ReplayToTheirDigests) {
  std::istringstream lines(read_text_file(MULTIREACH_SOURCE_DIR "/logs/REPLAY_DIGESTS"));
  std::string digest, name;
  int sessions = 0;
  while (lines >> digest >> name) {
    const ReplayOptions options{.session = MULTIREACH_SOURCE_DIR "/logs/" + name,
                                .from = ReplayFrom::kImages,
                                .robot = ReplayRobot::kIdeal,
                                .config = RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml"),
                                .vision = VisionConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/vision.yaml"),
                                .until_s = 1e9,
                                .threads = 2};
    const ReplayResult result = replay(
        options, [](int64_t, std::string_view, std::span<const uint8_t>, bool) {}, nullptr);
    EXPECT_EQ(fmt::format("{:016x}", static_cast<uint64_t>(result.digest)), digest) << name;
    EXPECT_EQ(result.damaged_bytes > 0, name == "damaged.lcm") << name << ": what was skipped is said";
    ++sessions;
  }
  EXPECT_EQ(sessions, 3);
}

}  // namespace
}  // namespace multireach
