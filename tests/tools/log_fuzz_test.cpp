// Damaged logs, for every reader of logs. MULTIREACH_LOG_MUTATIONS gives the number of damaged logs; default 1500.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <multireach/node_status_t.hpp>

#include "numeric/random.hpp"
#include "runtime/digest.hpp"
#include "runtime/files.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/log/export.hpp"
#include "tools/log/latency.hpp"
#include "tools/log/log_edit.hpp"
#include "tools/log/log_summary.hpp"
#include "tools/log/run_report.hpp"
#include "tools/replay/bisect.hpp"
#include "tools/replay/run.hpp"
#include "tools/replay/verify.hpp"

namespace multireach {
namespace {

const std::string kSource = MULTIREACH_SOURCE_DIR;
constexpr uint64_t kSeed = 14;
constexpr int64_t kMostLost = int64_t{1} << 41;  // messages; more cannot have been lost

class LogFuzz : public ::testing::Test {
 protected:
  LogFuzz() : robot_(RobotConfig::load(kSource + "/robots/hoap2/robot.yaml")) {
    write_whole_log();
    whole_ = read_text_file(path("whole"));
    for (size_t at = whole_.find("\xED\xA1\xDA\x01"); at != std::string::npos;
         at = whole_.find("\xED\xA1\xDA\x01", at + 1))
      events_.push_back(at);
  }

  std::string path(const std::string& name) const { return folder_ / name; }

  ReplayOptions options(const std::string& session, double until_s, ReplayFrom from) const {
    ReplayOptions options{.session = session,
                          .from = from,
                          .robot = ReplayRobot::kSimulated,
                          .config = robot_,
                          .vision = VisionConfig::load(kSource + "/robots/hoap2/vision.yaml"),
                          .until_s = until_s,
                          .threads = 1};
    return options;
  }

  /// The first messages of every channel of a replay, and a NODE_STATUS.
  void write_whole_log() const {
    constexpr int kOfEach = 8;
    std::map<std::string, int, std::less<>> written;
    LogWriter log(path("whole"));
    const auto sink = [&](int64_t at_us, std::string_view channel, std::span<const uint8_t> bytes, bool) {
      const int most = channel == "STEREO_IMAGES" ? 2 : kOfEach;
      if (written[std::string(channel)]++ < most) log.write(1'800'000'000'000'000 + at_us, channel, bytes);
    };
    replay(options(kSource + "/logs/reach.lcm", 0.5, ReplayFrom::kImages), sink, nullptr);
    node_status_t status{};
    status.node = "bridge";
    auto bytes = *encode(status);
    set_checksum(bytes);
    log.write(1'800'000'000'600'000, "NODE_STATUS", bytes);
    log.close();
  }

  /// A damaged copy of the log: flipped bits, bytes, headers of events, pieces cut out, doubled or cut off.
  std::string damaged(uint64_t k) const {
    const CounterRandom random(kSeed);
    uint64_t counter = k * 64;
    const auto below = [&](size_t limit) { return static_cast<size_t>(random.bits(counter++) % limit); };
    std::string bytes = whole_;
    const size_t changes = 1 + below(4);
    for (size_t change = 0; change < changes; ++change) {
      const size_t event = events_[below(events_.size())];
      switch (below(6)) {
        case 0:
          bytes[below(bytes.size())] ^= static_cast<char>(1 << below(8));
          break;
        case 1:
          bytes[std::min(event + below(28), bytes.size() - 1)] ^= static_cast<char>(1 << below(8));
          break;
        case 2:  // the highest byte of an integer: of the header, or anywhere
          bytes[std::min(event + 4 + 4 * below(20), bytes.size() - 1)] = static_cast<char>(below(2) ? 0x7f : 0x80);
          break;
        case 3: {
          const size_t begin = below(bytes.size());
          bytes.erase(begin, 1 + below(100));
          break;
        }
        case 4:
          bytes.insert(below(bytes.size()), bytes.substr(event % bytes.size(), 1 + below(400)));
          break;
        default:
          for (size_t i = 0, begin = below(bytes.size()); i < 8 && begin + i < bytes.size(); ++i)
            bytes[begin + i] = static_cast<char>(random.bits(counter++));
      }
    }
    if (below(8) == 0) bytes.resize(below(bytes.size()) + 1);
    return bytes;
  }

  void check_summary(const std::string& log) const {
    const LogSummary summary = summary_of(log);
    EXPECT_LE(summary.events, static_cast<int64_t>(2 * events_.size()));
    EXPECT_LT(summary.numbers.lost(), kMostLost);
    for (const auto& [name, channel] : summary.channels) {
      EXPECT_GE(channel.sequence.lost(), 0) << name;
      EXPECT_LT(channel.sequence.lost(), kMostLost) << name;
      EXPECT_GE(channel.sequence.damaged(), 0) << name;
      EXPECT_GE(channel.longest_gap_us, 0) << name;
    }
    write_json_file(path("json"), summary.json());
    EXPECT_FALSE(summary.table().empty());
  }

  void read_with(uint64_t reader, const std::string& log) const {
    std::vector<std::string> warnings;
    switch (reader) {
      case 0: {
        const RunReport report = report_on(log, robot_);
        EXPECT_LT(report.json["recording_lost"].get<int64_t>(), kMostLost);
        EXPECT_FALSE(table_of(report.json).empty());
        break;
      }
      case 1:
        merge_logs({log, path("whole")}, path("out"));
        break;
      case 2:
        cut_log(log, path("out"), 0.01, 0.4);
        break;
      case 3:
        filter_log(log, path("out"), {"JOINT_*"}, false);
        break;
      case 4:
        export_csv(log, path("csv"), {});
        std::filesystem::remove_all(path("csv"));
        break;
      case 5:
        export_mat(log, path("out"), {});
        break;
      case 6:
        export_mcap(log, path("out"), {});
        break;
      default:
        EXPECT_FALSE(latency_of(log).json().dump().empty());
    }
  }

  void compute_again(uint64_t what, const std::string& log) const {
    std::vector<std::string> warnings;
    switch (what) {
      case 0:
        replay(
            options(log, 0.3, replay_source(log)), [](int64_t, std::string_view, std::span<const uint8_t>, bool) {},
            nullptr);
        break;
      case 1:
        verify(log, {robot_, VisionConfig::load(kSource + "/robots/hoap2/vision.yaml")}, [](double) {});
        break;
      case 2:
        bisect(log, path("whole"), false, [](double) {});
        break;
      default:
        export_images(log, path("png"), {}, warnings);
    }
  }

  RobotConfig robot_;
  const testing::TemporaryFolder folder_{std::filesystem::is_directory("/dev/shm") ? "/dev/shm" : "/tmp"};
  std::string whole_;
  std::vector<size_t> events_;
};

/// No reader crashes, and a file that cannot be read is refused in a sentence.
TEST_F(LogFuzz, NoDamageCrashesAReader) {
  const char* number = std::getenv("MULTIREACH_LOG_MUTATIONS");
  const uint64_t mutations = number ? std::strtoull(number, nullptr, 10) : 1500;
  constexpr uint64_t kReaders = 8, kExpensive = 4, kExpensiveEvery = 32;
  ::testing::internal::CaptureStderr();  // the readers tell of the damage
  uint64_t refused = 0;
  for (uint64_t k = 0; k < mutations && !HasFailure(); ++k) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", log " + std::to_string(k));
    write_text_file(path("log"), damaged(k));
    try {
      check_summary(path("log"));
      read_with(k % kReaders, path("log"));
      if (k % kExpensiveEvery == 0) compute_again(k / kExpensiveEvery % kExpensive, path("log"));
    } catch (const InputError&) {
      ++refused;
    } catch (const std::exception& error) {
      ADD_FAILURE() << "no sentence for users: " << error.what();
    }
  }
  ::testing::internal::GetCapturedStderr();
  EXPECT_LT(refused, mutations / 10 + 10) << "most damage leaves something to read";
  RecordProperty("refused", static_cast<int>(refused));
}

}  // namespace
}  // namespace multireach
