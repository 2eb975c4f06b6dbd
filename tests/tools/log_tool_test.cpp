#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <multireach/bridge_state_t.hpp>
#include <multireach/node_inputs_t.hpp>
#include <multireach/node_status_t.hpp>
#include <multireach/target_candidates_t.hpp>
#include <multireach/target_t.hpp>

#include "numeric/random.hpp"
#include "runtime/digest.hpp"
#include "runtime/files.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/log/log_edit.hpp"
#include "tools/log/log_summary.hpp"
#include "tools/log/run_report.hpp"

namespace multireach {
namespace {

class LogTool : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  static std::vector<uint8_t> target(int64_t sequence) {
    target_t message{};
    message.sequence = sequence;
    return *encode(message);
  }

  /// `events` targets at 100 Hz, of which some were lost, and a channel of someone else's.
  std::string write(const std::string& name, int64_t events, int64_t begin = 1'000'000,
                    const std::vector<int64_t>& lost = {}) const {
    LogWriter log(path(name));
    const std::vector<uint8_t> foreign{1, 2, 3};
    for (int64_t k = 0; k < events; ++k) {
      if (std::ranges::find(lost, k) != lost.end()) continue;
      log.write(begin + 10000 * k, "TARGET", target(k));
      if (k % 10 == 0) log.write(begin + 10000 * k + 1, "THEIRS", foreign);
    }
    log.close();
    return path(name);
  }

  const testing::TemporaryFolder folder_;
};

TEST_F(LogTool, SummarisesChannels) {
  const LogSummary summary = summary_of(write("log", 100, 1'000'000, {30, 31, 77}));
  EXPECT_FALSE(summary.sound());
  EXPECT_EQ(summary.events, 97 + 9) << "an event of the other channel was at a lost place";
  const LogSummary::Channel& targets = summary.channels.at("TARGET");
  EXPECT_EQ(targets.type, "target_t");
  EXPECT_EQ(targets.events, 97);
  EXPECT_EQ(targets.sequence.lost(), 3);
  EXPECT_EQ(targets.longest_gap_us, 30000);
  EXPECT_NEAR(summary.json()["channels"]["TARGET"]["rate_hz"].get<double>(), 96 / 0.99, 1e-9);
  EXPECT_EQ(summary.channels.at("THEIRS").type, "?");
  EXPECT_TRUE(summary_of(write("whole", 100)).sound());
}

// They have the sequence numbers of their TARGETs, and not every TARGET has candidates.
TEST_F(LogTool, TargetsWithoutCandidatesAreNoLoss) {
  LogWriter log(path("run"));
  for (int64_t k = 0; k < 40; ++k) {
    target_candidates_t message{};
    message.sequence = k;
    if (k % 3 != 1) log.write(1'000'000 + 33'000 * k, "TARGET_CANDIDATES", *encode(message));
  }
  log.close();
  EXPECT_TRUE(summary_of(path("run")).sound());
}

TEST_F(LogTool, APublisherThatWasRestartedLostNothing) {
  write("one", 50, 1'000'000);
  write("two", 50, 9'000'000);
  merge_logs({path("two"), path("one")}, path("both"));
  const LogSummary summary = summary_of(path("both"));
  EXPECT_TRUE(summary.sound());
  EXPECT_EQ(summary.channels.at("TARGET").sequence.restarts(), 1);
  EXPECT_EQ(summary.channels.at("TARGET").events, 100);
}

TEST_F(LogTool, MergesThePartsOfARecorderThatWasKilled) {
  write("one", 50, 1'000'000);
  write("two", 50, 9'000'000);
  std::ofstream(path("empty")).flush();
  const std::vector<uint8_t> whole = read_binary_file(path("two"));
  std::ofstream(path("begin"), std::ios::binary).write(reinterpret_cast<const char*>(whole.data()), 20);
  merge_logs({path("one"), path("empty"), path("two"), path("begin")}, path("all"));
  EXPECT_EQ(summary_of(path("all")).channels.at("TARGET").events, 100);
  EXPECT_THROW(merge_logs({path("empty")}, path("none")), InputError);
  EXPECT_THROW(merge_logs({path("empty"), path("begin")}, path("none")), InputError);
  std::ofstream(path("text")) << "not a log";
  EXPECT_THROW(merge_logs({path("one"), path("text")}, path("none")), InputError);
}

TEST_F(LogTool, TheReportCountsRestartsSumsCountersAndComparesClocks) {
  LogWriter log(path("run"));
  const auto status = [&](int64_t second, int64_t uptime_s, int64_t late, const std::string& state = "holding") {
    node_status_t message{};
    message.node = "bridge";
    message.state = state;
    message.utime = second * 1'000'000 - 3'200'000;  // its clock is behind
    message.uptime_us = uptime_s * 1'000'000;
    message.late = late;
    message.lateness[2] = 100 * uptime_s;  // before the last restarts: 200 and 100 ticks of 32 to 64 us
    message.lateness[5] = late;            // and 5, 2 and 1 of 256 to 512 us
    auto bytes = *encode(message);
    set_checksum(bytes);
    log.write(second * 1'000'000, "NODE_STATUS", bytes);
    ++bytes[20];  // a garbled one counts as none
    log.write(second * 1'000'000, "NODE_STATUS", bytes);
  };
  status(10, 1, 0);
  status(11, 2, 5, "holding; refused: 7 unsigned, 1 altered");
  status(12, 0, 0);
  status(13, 1, 2);
  status(14, 0, 1);
  status(15, 0, 0, "idle; refused: 2 unsigned");
  log.close();
  const RunReport report = report_on(path("run"), RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml"));
  EXPECT_EQ(report.json["nodes"]["bridge"]["restarts"], 3);
  EXPECT_EQ(report.json["late_ticks"], 5 + 2 + 1);
  EXPECT_EQ(report.json["pairs_left_out"], 0);
  EXPECT_NEAR(report.json["nodes"]["bridge"]["clock_lead_ms"].get<double>(), -3200, 1e-9);
  EXPECT_EQ(report.json["nodes"]["bridge"]["lateness_us_p50"], 64);
  EXPECT_EQ(report.json["nodes"]["bridge"]["lateness_us_p99"], 512) << "8 of 308 ticks";
  const std::string table = table_of(report.json);
  EXPECT_NE(table.find("ticks of bridge began late by < 512 us (99 %)"), std::string::npos) << table;
  EXPECT_NE(table.find("bridge refused messages: 9 unsigned, 1 altered\n"), std::string::npos) << table;
  EXPECT_NE(table.find("restarts: bridge 3"), std::string::npos) << table;
  EXPECT_NE(table.find("clock of bridge: 3200 ms behind the recorder's"), std::string::npos) << table;
}

TEST_F(LogTool, TheReportSaysWhenTheBridgeIsSoLateThatTheArmMayCrawl) {
  for (const size_t bucket : {7, 9}) {  // 1024 to 2048 us, 4096 to 8192 us
    node_status_t message{};
    message.node = "bridge";
    message.utime = 1'700'000'000'000'000;
    message.lateness[2] = 980;
    message.lateness[bucket] = 20;
    auto bytes = *encode(message);
    set_checksum(bytes);
    LogWriter log(path("run"));
    log.write(message.utime, "NODE_STATUS", bytes);
    log.close();
    const std::string table =
        table_of(report_on(path("run"), RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml")).json);
    EXPECT_EQ(table.find("the arm may crawl") != std::string::npos, bucket == 9) << table;
  }
}

TEST_F(LogTool, TheReportNamesTheFaultsOfTheBridge) {
  LogWriter log(path("run"));
  int64_t k = 0;
  const auto state = [&](int8_t value, const std::string& cause, int64_t run) {
    bridge_state_t message{};
    message.utime = 1'700'000'000'000'000 + 500'000 * k++;
    message.run = run;
    message.state = value;
    message.cause = cause;
    log.write(message.utime, "BRIDGE_STATE", *encode(message));
  };
  state(bridge_state_t::RUNNING, "", 1);
  state(bridge_state_t::STOPPING, "set-points are late", 1);
  state(bridge_state_t::FAULT, "the robot does not follow its commands", 1);  // after 1 s
  state(bridge_state_t::FAULT, "the robot reports: stopped", 1);              // what follows from it
  state(bridge_state_t::RUNNING, "", 2);                                      // of another bridge
  state(bridge_state_t::FAULT, "the robot does not follow its commands", 1);
  state(bridge_state_t::RUNNING, "", 1);
  state(bridge_state_t::FAULT, "the robot was restarted", 1);  // after 3.5 s
  log.close();
  const RunReport report = report_on(path("run"), RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml"));
  ASSERT_EQ(report.json["bridge_faults"].size(), 2u) << report.json["bridge_faults"];
  EXPECT_DOUBLE_EQ(report.json["bridge_faults"][0]["at_s"].get<double>(), 1);
  const std::string table = table_of(report.json);
  EXPECT_NE(table.find("bridge in a fault from 3.50 s: the robot was restarted\n"), std::string::npos) << table;
}

TEST_F(LogTool, TheReportNamesStopsOfTheBridgeButNotTheEndOfTheRun) {
  LogWriter log(path("run"));
  constexpr int64_t kBegin = 1'700'000'000'000'000, kSecond = 1'000'000;
  const auto state = [&](int64_t seconds, int8_t value, const std::string& cause) {
    bridge_state_t message{};
    message.utime = kBegin + seconds * kSecond;
    message.run = 1;
    message.state = value;
    message.cause = cause;
    log.write(message.utime, "BRIDGE_STATE", *encode(message));
  };
  const auto target = [&](int64_t seconds) {
    target_t message{};
    message.utime = message.last_seen_utime = kBegin + seconds * kSecond;
    message.status = target_t::STATUS_TRACKED;
    log.write(message.utime, "TARGET", *encode(message));
  };
  target(0);
  state(0, bridge_state_t::IDLE, "waiting for the robot");
  state(1, bridge_state_t::RUNNING, "");
  state(2, bridge_state_t::STOPPING, "");
  state(3, bridge_state_t::IDLE, "disabled");
  state(4, bridge_state_t::RUNNING, "");
  state(5, bridge_state_t::RUNNING, "paused");
  state(6, bridge_state_t::RUNNING, "");
  target(7);
  state(8, bridge_state_t::STOPPING, "");
  log.close();
  const RunReport report = report_on(path("run"), RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml"));
  EXPECT_TRUE(report.json["bridge_faults"].empty());
  ASSERT_EQ(report.json["bridge_stops"].size(), 2u) << report.json["bridge_stops"];
  const std::string table = table_of(report.json);
  EXPECT_NE(table.find("bridge stopped at 2.00 s: disabled\nbridge stopped at 5.00 s: paused\n"), std::string::npos)
      << table;
}

TEST_F(LogTool, ATargetThatWasNeverSeenOrNeverInReachIsNoSuccess) {
  const RobotConfig robot = RobotConfig::load(MULTIREACH_SOURCE_DIR "/robots/hoap2/robot.yaml");
  int8_t seen_as = target_t::STATUS_TRACKED;
  const auto reason = [&](const char* name, int64_t last_seen, double x) {
    LogWriter log(path(name));
    for (int64_t k = 0; k < 90; ++k) {
      target_t message{};
      message.utime = 1'700'000'000'000'000 + 33'000 * k;
      message.last_seen_utime = last_seen < 0 ? -1 : message.utime;
      message.status = last_seen < 0 ? target_t::STATUS_LOST : seen_as;
      message.reason = "not in the left image";
      message.position_m[0] = x;
      log.write(message.utime, "TARGET", *encode(message));
    }
    log.close();
    const RunReport report = report_on(path(name), robot);
    EXPECT_FALSE(report.succeeded);
    return report.reason;
  };
  EXPECT_EQ(reason("unseen", -1, 0), "the target was never seen: not in the left image");
  EXPECT_EQ(reason("far", 0, 5), "none of the 1 positions is within the arm's reach");
  seen_as = target_t::STATUS_UNCALIBRATED;
  EXPECT_NE(reason("without_pose", 0, 0).find("vision.yaml needs cameras.left_to_robot"), std::string::npos);
}

TEST_F(LogTool, SaysWhereALogIsDamagedAndWhatIsMissingThere) {
  const std::string log = write("log", 200);
  const auto size = std::filesystem::file_size(log);
  {
    std::fstream file(log, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(0);
    file.seekp(static_cast<std::streamoff>(size / 2));
    file << std::string(700, 'x');
  }
  LogSummary summary = summary_of(log);
  EXPECT_FALSE(summary.sound());
  EXPECT_EQ(summary.damaged_places, 1);
  ASSERT_EQ(summary.damage.size(), 1u);
  EXPECT_NE(summary.damage[0].find("events are missing there"), std::string::npos) << summary.damage[0];
  EXPECT_EQ(summary.events + summary.numbers.lost(), 220);
  EXPECT_LE(summary.numbers.lost(), 5) << "only the damaged ones";
  std::filesystem::resize_file(log, size - 10);
  summary = summary_of(log);
  EXPECT_NE(summary.damage.back().find("cut off"), std::string::npos);
}

TEST_F(LogTool, OnlyAMessagesOwnSequenceNumberTellsOfLosses) {
  LogWriter log(path("log"));
  for (int64_t k = 0; k < 20; ++k) {
    bridge_state_t state{};
    state.sequence = 50 * k;  // of the newest JOINT_COMMAND
    log.write(50000 * k, "BRIDGE_STATE", *encode(state));
    node_inputs_t inputs{};
    inputs.num_inputs = 1;
    inputs.num_channels = 1;
    inputs.channel_name = {"TARGET"};
    inputs.channel = {0};
    inputs.ticks = {0};
    inputs.sequence = {3 * k};
    inputs.digest = {0};
    log.write(50000 * k + 1, "NODE_INPUTS", *encode(inputs));
  }
  log.close();
  EXPECT_TRUE(summary_of(path("log")).sound()) << summary_of(path("log")).table();
}

TEST_F(LogTool, AFlippedBitOfANumberIsDamageAndNoLoss) {
  const std::string log = write("log", 40);
  const std::string whole = read_text_file(log);
  // Of the 20th event: the eight bytes of the logger's number, and of the message's own, after the fingerprint and
  // utime.
  size_t event = 0;
  for (int k = 0; k < 20; ++k) event = whole.find("\xED\xA1\xDA\x01", event + 1);
  const size_t message = whole.find("TARGET", event) + 6;
  for (const auto& [begin, messages] : {std::pair(event + 4, false), std::pair(message + 16, true)}) {
    for (size_t bit = 0; bit < 48; ++bit) {
      std::string bytes = whole;
      bytes[begin + bit / 8] = static_cast<char>(bytes[begin + bit / 8] ^ (0x80 >> bit % 8));
      std::ofstream(log, std::ios::binary) << bytes;
      const LogSummary summary = summary_of(log);
      const SequenceGaps& hit = messages ? summary.channels.at("TARGET").sequence : summary.numbers;
      EXPECT_FALSE(summary.sound()) << "bit " << bit;
      EXPECT_EQ(hit.lost(), 0) << "bit " << bit;
      EXPECT_EQ(hit.damaged(), 1) << "bit " << bit;
    }
  }
}

TEST_F(LogTool, NoDamageCrashesIt) {
  const std::string log = write("log", 40);
  const std::string whole = read_text_file(log);
  const CounterRandom random(3);
  uint64_t counter = 0;
  for (int k = 0; k < 400; ++k) {
    std::string bytes = whole;
    for (int change = 0; change <= k % 7; ++change) {
      const auto at = static_cast<size_t>(random.uniform(counter++) * static_cast<double>(bytes.size()));
      bytes[at] = static_cast<char>(random.bits(counter++));
    }
    bytes.resize(bytes.size() - static_cast<size_t>(random.uniform(counter++) * 300));
    std::ofstream(log, std::ios::binary) << bytes;
    const LogSummary summary = summary_of(log);
    EXPECT_LE(summary.events, 45) << "seed 3, case " << k;
  }
}

TEST_F(LogTool, AMalformedMessageOfAKnownTypeIsCounted) {
  LogWriter log(path("log"));
  std::vector<uint8_t> bytes = target(0);
  log.write(1, "TARGET", bytes);
  bytes.pop_back();
  log.write(2, "TARGET", bytes);
  log.close();
  EXPECT_EQ(summary_of(path("log")).channels.at("TARGET").malformed, 1);
}

TEST_F(LogTool, CutsAndFilters) {
  const std::string log = write("log", 100);
  EXPECT_EQ(cut_log(log, path("cut"), 0.2, 0.5), 33);
  const LogSummary cut = summary_of(path("cut"));
  EXPECT_EQ(cut.channels.at("TARGET").events, 30);
  EXPECT_EQ(cut.first_utime, 1'000'000 + 200000);
  EXPECT_EQ(filter_log(log, path("some"), {"TAR*"}, false), 100);
  EXPECT_EQ(summary_of(path("some")).channels.size(), 1u);
  EXPECT_EQ(filter_log(log, path("others"), {"TAR*"}, true), 10);
  EXPECT_EQ(filter_log(log, path("none"), {"NOTHING"}, false), 0);
  EXPECT_THROW(cut_log(log, log, 0, 1), InputError);
  EXPECT_THROW(merge_logs({log}, log), InputError);
  EXPECT_THROW(summary_of(path("nowhere")), InputError);
}

}  // namespace
}  // namespace multireach
