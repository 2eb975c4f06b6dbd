#include "tools/log/latency.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <multireach/images_t.hpp>
#include <multireach/joint_command_t.hpp>
#include <multireach/joint_setpoint_t.hpp>
#include <multireach/target_t.hpp>

#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "tests/temporary_folder.hpp"

namespace multireach {
namespace {

/// Not inlined: GCC 12 warns about the arrays of a message that it knows to have none.
[[gnu::noinline]] std::vector<uint8_t> bytes_of(const images_t& message) {
  return *encode(message);
}

/// A log of a line with known delays. Messages are written in the order in which they are added.
class LogLatency : public ::testing::Test {
 protected:
  void images(int64_t arrival, int64_t utime) {
    images_t message{};
    message.utime = utime;
    log_.write(arrival, "STEREO_IMAGES", bytes_of(message));
  }
  void target(int64_t arrival, int64_t utime, int64_t sequence) {
    target_t message{};
    message.utime = utime;
    message.sequence = sequence;
    log_.write(arrival, "TARGET", *encode(message));
  }
  void setpoint(int64_t arrival, int64_t utime, int64_t sequence, int64_t target_sequence, int64_t run = 1) {
    joint_setpoint_t message{};
    message.utime = utime;
    message.sequence = sequence;
    message.run = run;
    message.target_sequence = target_sequence;
    log_.write(arrival, "JOINT_SETPOINT", *encode(message));
  }
  void command(int64_t arrival, int64_t utime, int64_t setpoint_sequence) {
    joint_command_t message{};
    message.utime = utime;
    message.setpoint_sequence = setpoint_sequence;
    log_.write(arrival, "JOINT_COMMAND", *encode(message));
  }
  void wire(int64_t arrival, const char* channel) { log_.write(arrival, channel, std::vector<uint8_t>(85)); }
  LatencyReport report() {
    log_.close();
    return latency_of(path_);
  }

  const testing::TemporaryFolder folder_;
  const std::string path_ = folder_ / "log";
  LogWriter log_{path_};
};

constexpr int64_t kBegin = 1'800'000'000'000'000;

// Every fifth command goes on the wire, 0.1 to 0.4 ms later; then a pause of 100 ms, and messages without a command.
TEST_F(LogLatency, GivesThePeriodsAndDelaysOnTheWire) {
  for (int64_t k = 0; k <= 1000; ++k) {
    const int64_t arrival = kBegin + 1000 * k;
    command(arrival, arrival, 1);
    if (k % 5 == 0) wire(arrival + 100 + 100 * (k / 5 % 4), "IIWA_COMMAND");
  }
  const int64_t later = kBegin + 1'100'000;
  for (int64_t k = 0; k < 10; ++k) wire(later + 5000 * k, "IIWA_COMMAND");
  wire(later, "ANOTHER_COMMAND");
  const LatencyReport report = this->report();
  ASSERT_EQ(report.wires.size(), 1U);
  const LatencyReport::Wire& iiwa = report.wires[0];
  EXPECT_EQ(iiwa.channel, "IIWA_COMMAND");
  EXPECT_EQ(iiwa.period.count, 200);
  EXPECT_EQ(iiwa.delay.count, 200);
  EXPECT_NEAR(iiwa.delay.max_ms, 0.4, 1e-9);
  EXPECT_NEAR(iiwa.delay.p50_ms, 0.25, 0.051);
  EXPECT_NEAR(iiwa.period.max_ms, 5.1, 1e-9);
  EXPECT_NE(report.table().find("IIWA_COMMAND: period p50 5.10"), std::string::npos) << report.table();
}

TEST_F(LogLatency, GivesTheDelaysOfEachStage) {
  // The delays of pair k: 3 ms to the receipt of the images, k ms more to TARGET, 2 to the set-point, 5 to the command.
  // The set-point is for 20 ms after the capture, the command for 28 ms after it.
  for (int64_t k = 0; k <= 100; ++k) {
    const int64_t capture = kBegin + 1'000'000 * k, seen = capture + 3000 + 1000 * k;
    images(capture + 3000, capture);
    target(seen, capture, k);
    setpoint(seen + 2000, capture + 20000, 500 + k, k);
    command(seen + 3000, capture + 27000, 500 + k - 1);
    command(seen + 7000, capture + 28000, 500 + k);
    command(seen + 8000, capture + 29000, 500 + k);
  }
  const LatencyReport report = this->report();
  EXPECT_EQ(report.targets, 101);
  EXPECT_EQ(report.taken_up, 101);
  EXPECT_EQ(report.without_command, 0);
  ASSERT_EQ(report.stages.size(), 5U);
  const auto expect = [&](size_t stage, double p50, double p95, double p99, double by_message) {
    const auto& [from, to, arrival, message] = report.stages[stage];
    SCOPED_TRACE(from + " -> " + to);
    EXPECT_EQ(arrival.count, 101);
    EXPECT_NEAR(arrival.p50_ms, p50, 1e-9);
    EXPECT_NEAR(arrival.p95_ms, p95, 1e-9);
    EXPECT_NEAR(arrival.p99_ms, p99, 1e-9);
    if (stage > 0) {
      EXPECT_NEAR(message.p50_ms, by_message, 1e-9);
    }
  };
  expect(0, 3, 3, 3, 0);
  EXPECT_EQ(report.stages[0].by_message.count, 0);
  expect(1, 50, 95, 99, 0);
  expect(2, 2, 2, 2, 20);
  expect(3, 5, 5, 5, 8);
  expect(4, 57, 102, 106, 28);
}

TEST_F(LogLatency, CountsOnlyTargetsThatATickTakesUp) {
  for (int64_t k = 0; k < 3; ++k) target(kBegin + 1000 * k, kBegin, k);
  setpoint(kBegin + 10000, kBegin, 0, -1);
  setpoint(kBegin + 20000, kBegin, 1, 2);
  setpoint(kBegin + 30000, kBegin, 2, 2);  // the same target again
  command(kBegin + 31000, kBegin, 2);      // set-point 1 was never followed
  const LatencyReport report = this->report();
  EXPECT_EQ(report.targets, 3);
  EXPECT_EQ(report.taken_up, 1);
  EXPECT_EQ(report.without_command, 1);
  EXPECT_EQ(report.stages[2].by_arrival.p50_ms, 18);
  EXPECT_EQ(report.stages[3].by_arrival.count, 0);
}

TEST_F(LogLatency, ARestartedNodeIsNotConfusedWithItsEarlierRun) {
  for (int64_t run = 0; run < 2; ++run) {
    const int64_t at = kBegin + 100'000'000 * run;
    target(at, at, 7);
    setpoint(at + 4000, at, 3, 7, 1 + run);
    command(at + 5000, at, 3);
    command(at + 6000, at, -1);
  }
  const LatencyReport report = this->report();
  EXPECT_EQ(report.taken_up, 2);
  EXPECT_EQ(report.stages[2].by_arrival.max_ms, 4);
  EXPECT_EQ(report.stages[3].by_arrival.max_ms, 1);
}

}  // namespace
}  // namespace multireach
