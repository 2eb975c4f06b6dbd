// Large logs in the page: what opening them reads, and whether all of their events can be found.
#include <gtest/gtest.h>

#include <bit>
#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <optional>

#include "runtime/channels.hpp"
#include "runtime/message.hpp"
#include "tests/temporary_folder.hpp"
#include "tools/page/log_index.hpp"

namespace multireach {
namespace {

/// What a log has before the bytes of a message: mark, number, time, two lengths, and the channel's name.
std::string header(int64_t number, int64_t utime, const std::string& channel, uint32_t size) {
  std::string bytes;
  const auto append = [&bytes](auto value) {
    for (size_t i = sizeof value; i-- > 0;) bytes += static_cast<char>(static_cast<uint64_t>(value) >> (8 * i) & 0xff);
  };
  append(uint32_t{0xeda1da01});
  append(number);
  append(utime);
  append(static_cast<uint32_t>(channel.size()));
  append(size);
  return bytes + channel;
}

/// Bytes of a mapped file that this process has read, by pages and what the system maps around them; nothing where the
/// system does not tell.
std::optional<int64_t> bytes_read(const std::string& path) {
  std::ifstream maps("/proc/self/smaps");
  bool is_of_file = false;
  for (std::string line; std::getline(maps, line);) {
    int64_t kibibytes = 0;
    if (line.ends_with(path)) is_of_file = true;
    if (is_of_file && std::sscanf(line.c_str(), "Rss: %" SCNd64, &kibibytes) == 1) return kibibytes * 1024;
  }
  return std::nullopt;
}

TEST(LargeLog, AMillionEventsAreFoundByTimeAndSender) {
  constexpr int64_t kEvents = 1000000, kPeriod = 1000;  // us
  const testing::TemporaryFolder folder;
  const std::string path = folder / "million";
  {
    std::ofstream file(path, std::ios::binary);
    const std::string state(16, '\1'), setpoint(16, '\2');
    for (int64_t i = 0; i < kEvents; ++i) {
      const bool is_setpoint = i % 50 == 0;
      file << header(i, i * kPeriod, std::string(is_setpoint ? channel::kJointSetpoint : channel::kRobotState), 16)
           << (is_setpoint ? setpoint : state);
    }
  }
  const LogIndex log(path);
  ASSERT_EQ(log.size(), kEvents);
  EXPECT_EQ(log.duration_us(), (kEvents - 1) * kPeriod);
  const LogIndex::Series* setpoints = log.series_of(channel::kJointSetpoint);
  ASSERT_TRUE(setpoints);
  EXPECT_EQ(setpoints->events.size(), static_cast<size_t>(kEvents / 50));
  for (const int64_t i : {int64_t{0}, int64_t{49}, int64_t{50}, kEvents / 2 + 7, kEvents - 1}) {
    EXPECT_EQ(log.event_before(i * kPeriod + 1), i);
    EXPECT_EQ(LogIndex::newest(*setpoints, i), i / 50 * 50);
    EXPECT_EQ(log.event(i).data.front(), i % 50 == 0 ? 2 : 1);
  }
}

TEST(LargeLog, OpeningItReadsNoImages) {
  // Two gigabytes of images that are holes of the file: zeros, which take no place on the disk until they are read.
  constexpr int64_t kEvents = 2000;
  constexpr uint32_t kSize = 1000000;
  const testing::TemporaryFolder folder;
  const std::string path = folder / "images";
  {
    std::ofstream file(path, std::ios::binary);
    for (int64_t i = 0; i < kEvents; ++i) {
      file << header(i, i * 33333, std::string(channel::kStereoImages), kSize);
      file.seekp(kSize, std::ios::cur);
    }
    file.seekp(-1, std::ios::cur);
    file.put('\0');
  }
  const LogIndex log(path);
  ASSERT_EQ(log.size(), kEvents);
  const auto read = bytes_read(path);
  if (!read) GTEST_SKIP() << "/proc/self/smaps does not tell what was read";
  // A header and the end of its message are in one place, or in two; the system maps at most 64 KiB around each
  // (fault_around_bytes).
  EXPECT_LE(*read, 2 * kEvents * 65536);
  // Reading one byte of each page is noticed.
  int64_t sum = 0;
  for (int64_t i = 0; i < kEvents; ++i)
    for (size_t at = 0; at < kSize; at += 4096) sum += log.event(i).recorded[at];
  EXPECT_EQ(sum, 0);
  EXPECT_GE(bytes_read(path).value(), kEvents * kSize);
}

}  // namespace
}  // namespace multireach
