// A rendered tag as a pose target, from images to a moving arm, in virtual time.
#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>

#include "tests/temporary_folder.hpp"
#include "tests/tools/pose_errors.hpp"
#include "tests/tools/rendered_session.hpp"
#include "tools/replay/run.hpp"
#include "tools/replay/verify.hpp"

namespace multireach {
namespace {

const std::string kExample = MULTIREACH_SOURCE_DIR "/examples/tag";

class TagSession : public ::testing::Test {
 protected:
  /// Renders the session and replays it once, for all tests.
  static void SetUpTestSuite() {
    folder_.emplace();
    testing::render_session(kExample + "/scene.yaml", path("session.lcm"));
    result_ = run(2, "run.lcm");
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string path(const std::string& name) { return *folder_ / name; }

  static ReplayOptions options(int threads) {
    return {.session = path("session.lcm"),
            .from = ReplayFrom::kImages,
            .robot = ReplayRobot::kSimulated,
            .config = RobotConfig::load(kExample),
            .vision = VisionConfig::load(kExample + "/vision.yaml"),
            .until_s = 1e9,
            .threads = threads};
  }
  static ReplayResult run(int threads, const std::string& name) {
    LogWriter log(path(name));
    const ReplayResult result = replay(
        options(threads),
        [&](int64_t at, std::string_view channel, std::span<const uint8_t> bytes, bool) {
          log.write(1'000'000'000 + at, channel, bytes);
        },
        nullptr);
    log.close();
    return result;
  }

  inline static std::optional<testing::TemporaryFolder> folder_;
  inline static ReplayResult result_;
};

TEST_F(TagSession, TheHandTakesTheTagsPose) {
  const std::vector<PoseError> errors = pose_errors(path("run.lcm"), RobotConfig::load(kExample).chain, 3);
  EXPECT_EQ(errors.size(), 3U);
  for (const PoseError& error : errors) {
    EXPECT_LT(error.position_m, 0.002) << error.at_s;
    EXPECT_LT(error.angle_rad, std::numbers::pi / 180) << error.at_s;
    std::printf("%.2f s: %.3f mm, %.3f degrees\n", error.at_s, 1e3 * error.position_m,
                error.angle_rad * 180 / std::numbers::pi);
  }
  EXPECT_EQ(run(1, "again.lcm").digest, result_.digest);
}

TEST_F(TagSession, IsComputedAgainToTheSameBytes) {
  const ReplayOptions same = options(1);
  const Verification whole = verify(path("run.lcm"), {same.config, same.vision}, [](double) {});
  EXPECT_TRUE(whole.holds()) << whole.first->sentence();
  EXPECT_EQ(whole.channels.at("TARGET").equal, 180);
  // Without every fifth pair of images, the state that vision sent for it continues the tag's track and orientation.
  LogReader reader(path("run.lcm"));
  LogWriter writer(path("thinned.lcm"));
  int pairs = 0;
  while (const auto event = reader.next()) {
    if (event->channel == channel::kStereoImages && ++pairs % 5 == 0) continue;
    writer.write(event->utime, event->channel, event->data);
  }
  writer.close();
  const Verification thinned = verify(path("thinned.lcm"), {same.config, same.vision}, [](double) {});
  EXPECT_TRUE(thinned.holds()) << thinned.first->sentence();
  EXPECT_EQ(thinned.channels.at("TARGET").equal, 144);
}

}  // namespace
}  // namespace multireach
