// Thrown balls, from rendered images to a moving arm, in virtual time.
#include <gtest/gtest.h>

#include <filesystem>

#include "runtime/log_file.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tools/rendered_session.hpp"
#include "tools/log/flights.hpp"
#include "tools/log/run_report.hpp"
#include "tools/replay/run.hpp"
#include "tools/replay/verify.hpp"

namespace multireach {
namespace {

const std::string kExample = MULTIREACH_SOURCE_DIR "/examples/throws";

class ThrowSession : public ::testing::Test {
 protected:
  void SetUp() override { testing::render_session(kExample + "/scene.yaml", folder_ / "session.lcm"); }

  RunReport run(const RobotConfig& robot) {
    LogWriter log(folder_ / "run.lcm");
    replay(
        {.session = folder_ / "session.lcm",
         .from = ReplayFrom::kImages,
         .robot = ReplayRobot::kSimulated,
         .config = robot,
         .vision = VisionConfig::load(kExample + "/vision.yaml"),
         .until_s = 1e9,
         .threads = 2},
        [&](int64_t at, std::string_view channel, std::span<const uint8_t> bytes, bool) {
          log.write(1'000'000'000 + at, channel, bytes);
        },
        nullptr);
    log.close();
    return report_on(folder_ / "run.lcm", robot);
  }
  const testing::TemporaryFolder folder_;
};

TEST_F(ThrowSession, TheHandMeetsTheBallAndTheRunVerifies) {
  const RobotConfig robot = RobotConfig::load(kExample);
  const RunReport report = run(robot);
  EXPECT_TRUE(report.succeeded) << report.reason;
  ASSERT_EQ(report.json["flights"].size(), 3U);
  for (const nlohmann::json& flight : report.json["flights"])
    std::printf("closest %.1f mm\n", flight["closest_mm"].get<double>());
  const Verification again =
      verify(folder_ / "run.lcm", {robot, VisionConfig::load(kExample + "/vision.yaml")}, [](double) {});
  EXPECT_TRUE(again.holds()) << again.first->sentence();
}

/// The report, against a flight and a hand that are given.
TEST(Flights, AreFoundWithTheirClosestApproach) {
  const RobotConfig robot = RobotConfig::load(kExample);
  const controller::MultiStartIk search(robot.chain);
  const JointVector anywhere = robot.chain.clamped(JointVector::Zero(4));
  std::vector<target_t> targets;
  std::vector<TimedPosition> hand;
  const Eigen::Vector3d from(0.5, -0.14, 0), velocity(-1, 0, 2.5), beside(0, 0.012, 0);
  const auto body = [&](double t) -> Eigen::Vector3d {
    return from + t * velocity - 0.5 * t * t * 9.81 * Eigen::Vector3d::UnitZ();
  };
  for (int k = 0; k < 45; ++k) {  // held for half a second, thrown, 0.5 s of flight, then out of view
    target_t& target = targets.emplace_back();
    target.utime = 33333 * k;
    target.status = k < 31 ? target_t::STATUS_TRACKED : target_t::STATUS_LOST;
    Eigen::Map<Eigen::Vector3d>(target.position_m) = body(std::max(0.0, 1e-6 * static_cast<double>(33333 * (k - 15))));
  }
  const double meets = 0.43;  // s after the release, at 15 * 33333 us
  for (int64_t utime = 0; utime < 1500000; utime += 5000) hand.push_back({utime, body(meets) + beside});
  const nlohmann::json flights = flights_of(targets, std::nullopt, hand, {}, search, anywhere, 0);
  ASSERT_EQ(flights.size(), 1U);
  EXPECT_GT(flights[0]["begin_s"].get<double>(), 17 * 0.033333) << "three images show an acceleration at the earliest";
  EXPECT_LT(flights[0]["begin_s"].get<double>(), 15 * 0.033333 + meets) << "before they meet";
  // Samples of the hand are 5 ms apart: 1 cm of the body's way.
  EXPECT_NEAR(flights[0]["closest_mm"].get<double>(), 12, 1);
  EXPECT_NEAR(flights[0]["closest_s"].get<double>(), 15 * 0.033333 + meets, 0.006);
  EXPECT_TRUE(flights[0]["reachable"].get<bool>());
  // Another object, and a message of an hour later, do not hide the flight.
  std::vector<target_t> more;
  for (const target_t& target : targets) {
    more.push_back(target);
    more.push_back(target);
    more.back().name = "other";
    more.back().position_m[0] += 1;
    if (more.size() == 10) more.push_back(targets.front()), more.back().utime += 3'600'000'000;
  }
  const nlohmann::json same = flights_of(more, std::nullopt, hand, {}, search, anywhere, 0);
  ASSERT_EQ(same.size(), 1U);
  EXPECT_NEAR(same[0]["closest_mm"].get<double>(), flights[0]["closest_mm"].get<double>(), 1e-6);
}

}  // namespace
}  // namespace multireach
