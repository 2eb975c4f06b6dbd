// Two equal balls: what vision sends of them, and that a replay computes it again.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <multireach/images_t.hpp>
#include <multireach/target_candidates_t.hpp>
#include <multireach/target_t.hpp>
#include <opencv2/imgproc.hpp>

#include "runtime/channels.hpp"
#include "runtime/log_file.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tools/ball_images.hpp"
#include "tools/replay/run.hpp"
#include "tools/replay/verify.hpp"

namespace multireach {
namespace {

const std::string kRobots = MULTIREACH_SOURCE_DIR "/robots/hoap2/";
const Eigen::Vector3d kFirst(0.09, -0.06, 0.08), kSecond(0.09, -0.16, 0.08);
constexpr int kPairs = 12;

cv::Mat with_both(const BallRenderer& camera, uint64_t stream) {
  cv::Mat image = camera.render(kFirst, stream);
  testing::add_ball(camera, kSecond, stream, image);
  return image;
}

images_t pair_of(const StereoRig& rig, int k) {
  const SceneOptions scene{.distractors = 0};
  const BallRenderer left(scene, rig.left, rig.X_WL, rig.X_WL);
  const BallRenderer right(scene, rig.right, rig.X_WL * rig.X_RL.inverse(), rig.X_WL);
  images_t pair{};
  pair.utime = 1'000'000 + k * 33'333;
  pair.n_images = 2;
  pair.image_types = {images_t::LEFT, images_t::RIGHT};
  for (const BallRenderer* camera : {&left, &right}) {
    const cv::Mat bgr = with_both(*camera, static_cast<uint64_t>(2 * k + (camera == &right ? 1 : 0)));
    pair.images.push_back(testing::image_message(bgr, pair.utime));
  }
  return pair;
}

TEST(CandidatesSession, TwoEqualBallsAreSentAsAmbiguousWithBothAndVerified) {
  const testing::TemporaryFolder folder;
  const NodeConfigs configs{RobotConfig::load(kRobots + "robot.yaml"), VisionConfig::load(kRobots + "vision.yaml")};
  {
    LogWriter session(folder / "session");
    for (int k = 0; k < kPairs; ++k) {
      const images_t pair = pair_of(configs.vision->rig, k);
      session.write(pair.utime, channel::kStereoImages, *encode(pair));
    }
    session.close();
  }
  std::vector<target_t> targets;
  std::vector<target_candidates_t> sent;
  LogWriter log(folder / "log");
  const ReplayOptions options{.session = folder / "session",
                              .from = replay_source(folder / "session"),
                              .robot = ReplayRobot::kIdeal,
                              .config = configs.robot,
                              .vision = configs.vision,
                              .until_s = 1,
                              .threads = 1};
  replay(
      options,
      [&](int64_t at, std::string_view channel, std::span<const uint8_t> bytes, bool) {
        log.write(1'000'000'000 + at, channel, bytes);
        if (channel == channel::kTarget) targets.push_back(*decode<target_t>(bytes));
        if (channel == channel::kTargetCandidates) sent.push_back(*decode<target_candidates_t>(bytes));
      },
      nullptr);
  log.close();

  ASSERT_EQ(targets.size(), static_cast<size_t>(kPairs));
  ASSERT_EQ(sent.size(), targets.size()) << "each of them has more than one candidate";
  for (size_t k = 0; k < sent.size(); ++k) {
    EXPECT_EQ(targets[k].status, target_t::STATUS_AMBIGUOUS) << targets[k].reason;
    EXPECT_EQ(targets[k].reason, "several things could be the target");
    EXPECT_EQ(targets[k].last_seen_utime, -1);
    EXPECT_EQ(sent[k].sequence, targets[k].sequence);
    EXPECT_EQ(sent[k].utime, targets[k].utime);
    EXPECT_EQ(sent[k].run, targets[k].run);
    EXPECT_EQ(sent[k].name, targets[k].name);
    ASSERT_GE(sent[k].num_candidates, 2);
    for (const Eigen::Vector3d& ball : {kFirst, kSecond}) {
      const auto at_ball = [&](const target_candidate_t& candidate) {
        return (Eigen::Map<const Eigen::Vector3d>(candidate.position_m) - ball).norm() < 0.005;
      };
      EXPECT_EQ(std::count_if(sent[k].candidates.begin(), sent[k].candidates.begin() + 2, at_ball), 1);
    }
    for (const target_candidate_t& candidate : sent[k].candidates) {
      EXPECT_FALSE(candidate.chosen);
      EXPECT_NEAR(candidate.score,
                  candidate.still_score + candidate.round_score + candidate.colour_score + candidate.stereo_score +
                      candidate.size_score + candidate.history_score,
                  1e-12);
      EXPECT_FALSE(candidate.reason.empty());
    }
  }
  const Verification verification = verify(folder / "log", configs, [](double) {});
  EXPECT_TRUE(verification.holds()) << verification.first->sentence();
  EXPECT_EQ(verification.channels.at("TARGET_CANDIDATES").equal, kPairs);
  EXPECT_EQ(verification.channels.at("TARGET").equal, kPairs);
}

}  // namespace
}  // namespace multireach
