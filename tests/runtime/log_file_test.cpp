#include "runtime/log_file.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "numeric/random.hpp"
#include "runtime/files.hpp"
#include "tests/temporary_folder.hpp"

namespace multireach {
namespace {

class LogFile : public ::testing::Test {
 protected:
  void SetUp() override {
    LogWriter writer(path_);
    for (int64_t k = 0; k < kEvents; ++k) writer.write(1000 * k, k % 2 ? "ODD" : "EVEN", payload(k));
    writer.close();
    bytes_ = read_binary_file(path_);
  }
  static std::vector<uint8_t> payload(int64_t k) {
    return std::vector<uint8_t>(static_cast<size_t>(k % 7), static_cast<uint8_t>(k));
  }
  void write(const std::vector<uint8_t>& bytes) const { write_text_file(path_, {bytes.begin(), bytes.end()}); }

  static constexpr int64_t kEvents = 100;
  const testing::TemporaryFolder folder_;
  const std::string path_ = folder_ / "log";
  std::vector<uint8_t> bytes_;
};

TEST_F(LogFile, ComesBackAsItWasWritten) {
  LogReader reader(path_);
  for (int64_t k = 0; k < kEvents; ++k) {
    const auto event = reader.next();
    ASSERT_TRUE(event);
    EXPECT_EQ(event->number, k);
    EXPECT_EQ(event->utime, 1000 * k);
    EXPECT_EQ(event->channel, k % 2 ? "ODD" : "EVEN");
    EXPECT_EQ(std::vector<uint8_t>(event->data.begin(), event->data.end()), payload(k));
  }
  EXPECT_FALSE(reader.next());
  EXPECT_EQ(reader.damaged_bytes(), 0U);
}

TEST_F(LogFile, ACutOffLogLosesOnlyItsLastEvent) {
  bytes_.resize(bytes_.size() - 1);
  write(bytes_);
  LogReader reader(path_);
  int64_t events = 0;
  while (reader.next()) ++events;
  EXPECT_EQ(events, kEvents - 1);
  EXPECT_EQ(reader.damaged_places(), 1U);
}

TEST_F(LogFile, DamageLosesOnlyTheDamagedEvents) {
  // The length of the 50th event becomes 0x7fffffff, at which LCM's own reader crashes.
  size_t position = 0;
  for (int64_t k = 0; k < 50; ++k) position += 28 + (k % 2 ? 3 : 4) + payload(k).size();
  ASSERT_EQ(bytes_[position], 0xED);
  bytes_[position + 24] = 0x7f;
  for (size_t i = 25; i < 28; ++i) bytes_[position + i] = 0xff;
  write(bytes_);
  LogReader reader(path_);
  std::vector<int64_t> numbers;
  while (const auto event = reader.next()) numbers.push_back(event->number);
  EXPECT_EQ(numbers.size(), static_cast<size_t>(kEvents - 1));
  EXPECT_EQ(std::count(numbers.begin(), numbers.end(), 50), 0);
  EXPECT_EQ(reader.damaged_places(), 1U);
}

/// Of an event that is damaged in its header, at most that event is lost, and no other is made up.
TEST_F(LogFile, AByteInAHeaderLosesAtMostOneEvent) {
  std::vector<size_t> begins;
  for (size_t position = 0, k = 0; k < kEvents; ++k) {
    begins.push_back(position);
    position += 28 + (k % 2 ? 3 : 4) + payload(static_cast<int64_t>(k)).size();
  }
  constexpr uint64_t kSeed = 8;
  const CounterRandom random(kSeed);
  for (uint64_t k = 0; k < 3000; ++k) {
    std::vector<uint8_t> damaged = bytes_;
    const size_t event = random.bits(3 * k) % kEvents, offset = random.bits(3 * k + 1) % 28;
    damaged[begins[event] + offset] ^= static_cast<uint8_t>(1 + random.bits(3 * k + 2) % 255);
    write(damaged);
    LogReader reader(path_);
    int64_t sound = 0, others = 0;
    while (const auto read = reader.next()) {
      const int64_t number = read->number;
      const bool known = number >= 0 && number < kEvents;
      const bool right =
          known && read->channel == (number % 2 ? "ODD" : "EVEN") && std::ranges::equal(read->data, payload(number));
      ++(right ? sound : others);
    }
    EXPECT_GE(sound, kEvents - 1) << "seed " << kSeed << ", case " << k << ", event " << event << ", byte " << offset;
    EXPECT_LE(others, 1) << "seed " << kSeed << ", case " << k << ", event " << event << ", byte " << offset;
    const bool in_lengths = offset >= 20;
    if (in_lengths && event + 1 < kEvents) {
      EXPECT_EQ(others, 0) << "a wrong length is seen";
    }
  }
}

TEST_F(LogFile, NoDamageCrashesIt) {
  constexpr uint64_t kSeed = 7;
  const CounterRandom random(kSeed);
  for (uint64_t k = 0; k < 2000; ++k) {
    std::vector<uint8_t> damaged = bytes_;
    for (uint64_t i = 0; i < 8; ++i)
      damaged[random.bits(16 * k + 2 * i) % damaged.size()] = static_cast<uint8_t>(random.bits(16 * k + 2 * i + 1));
    write(damaged);
    LogReader reader(path_);
    size_t total = 0;
    while (const auto event = reader.next()) {
      for (const uint8_t byte : event->data) total += byte;
      total += event->channel.size();
    }
    EXPECT_GT(total, 0U) << "seed " << kSeed << ", case " << k;
  }
}

TEST_F(LogFile, SaysWhatIsNoLog) {
  EXPECT_THROW(LogReader("/nowhere/log"), InputError);
  EXPECT_THROW(LogReader("/tmp"), InputError);
  write_text_file(path_, "");
  EXPECT_THROW(LogReader{path_}, InputError);
  write_text_file(path_, "this is a text and no log");
  EXPECT_THROW(LogReader{path_}, InputError);
}

}  // namespace
}  // namespace multireach
