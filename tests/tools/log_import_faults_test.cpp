// Recordings that are wrong or damaged.
#include <gtest/gtest.h>

#include <algorithm>

#include "numeric/random.hpp"
#include "tests/tools/recordings.hpp"

namespace multireach {
namespace {

TEST_F(LogImport, FaultsOfRecordingsNameFileByteAndWhatWasExpected) {
  const std::string one_left = bag_message(0, 5000000, ros1_raw(5000000, 4, 2, "mono8", 4, "12345678"));
  const std::string topics = connection(0, "/left", "sensor_msgs/Image") + connection(1, "/right", "sensor_msgs/Image");
  const auto bag_fault = [&](const std::string& records) { return import_fault(written("x.bag", bag(records))); };
  const std::string file = path("x.bag");
  EXPECT_NE(bag_fault(one_left).find("a message is of the topic number 0, which is not declared"), std::string::npos);
  EXPECT_EQ(bag_fault(topics + one_left), file + ": '/right' has no image; expected at least one");
  const std::string depth = bag_message(1, 5000000, ros1_raw(5000000, 4, 2, "16UC1", 8, std::string(16, ' ')));
  const std::string said = bag_fault(topics + one_left + depth);
  EXPECT_NE(said.find(": the encoding '16UC1' is not supported; expected one of rgba8, bgra8, mono8"),
            std::string::npos)
      << said;
  EXPECT_TRUE(said.starts_with(file + ": byte ")) << said;
  const std::string wide = bag_message(1, 5000000, ros1_raw(5000000, 400000, 2, "mono8", 4, "12345678"));
  EXPECT_NE(bag_fault(topics + one_left + wide).find("the image has 400000 x 2 pixels; expected 2 to 16384"),
            std::string::npos);
  const std::string too_few = bag_message(1, 5000000, ros1_raw(5000000, 4, 2, "mono8", 4, "1234"));
  EXPECT_NE(bag_fault(topics + one_left + too_few).find("cannot be decoded"), std::string::npos);
  EXPECT_NE(
      bag_fault(bag_record(field("op", little(5, 1)) + field("compression", "xz") + field("size", little(9, 4)), "x"))
          .find("has the compression 'xz'; expected none, lz4, zstd or bz2"),
      std::string::npos);
  EXPECT_NE(
      bag_fault(bag_record(field("op", little(5, 1)) + field("compression", "bz2") + field("size", little(9, 4)), "x"))
          .find(": chunk at byte 4109: its bz2 data are damaged"),
      std::string::npos);
  EXPECT_NE(bag_fault(bag_record(field("op", little(5, 1)) + field("compression", "lz4") +
                                     field("size", little(0xfffffff0, 4)),
                                 "x"))
                .find("at most 1 GB"),
            std::string::npos);
  EXPECT_NE(bag_fault(bag_record("\x05\1\1\1", "")).find("expected a field of a header of 16843013 bytes"),
            std::string::npos);

  written("run.mcap", recorded_mcap("zstd"));
  options_.left = "";
  EXPECT_EQ(import_fault(path("run.mcap")),
            path("run.mcap") + ": --left is missing; expected a topic; its topics with images are /left, /right");
  options_.left = "/words";
  EXPECT_NE(import_fault(path("run.mcap")).find("is of type 'std_msgs/msg/String'"), std::string::npos);
  options_.left = "/nothing";
  EXPECT_NE(import_fault(path("run.mcap")).find("has no topic '/nothing' (--left)"), std::string::npos);
  options_.left = "/right";
  EXPECT_NE(import_fault(path("run.mcap")).find("the same topic"), std::string::npos);
  options_.left = "/left";
  std::string damaged = recorded_mcap("");
  damaged[damaged.size() / 14] ^= 1;  // in an image of the first chunk, which has a checksum
  EXPECT_NE(import_fault(written("damaged.mcap", damaged)).find("does not have the checksum"), std::string::npos);

  // A recorder that was killed leaves what it had written.
  const std::string whole = recorded_mcap("lz4");
  const ImportSummary cut = import(written("cut.mcap", whole.substr(0, whole.size() * 2 / 3)));
  EXPECT_GT(cut.pairs, 5);
  EXPECT_LT(cut.pairs, static_cast<int64_t>(kPairs));
  EXPECT_NE(cut.warning.find("is cut off at byte "), std::string::npos);
}

/// No damage crashes a reader, takes much memory, or gives more images than were recorded.
TEST_F(LogImport, DamagedRecordingsAreReadOrRefusedInASentence) {
  constexpr uint64_t kSeed = 23;
  const char* number = std::getenv("MULTIREACH_LOG_MUTATIONS");
  const uint64_t mutations = number ? std::strtoull(number, nullptr, 10) : 1500;
  pairs_.resize(4);
  const std::vector<std::string> whole{recorded_mcap(""),    recorded_mcap("lz4"), recorded_mcap("zstd"),
                                       recorded_bag("none"), recorded_bag("bz2"),  recorded_bag("lz4")};
  const CounterRandom random(kSeed);
  uint64_t refused = 0;
  for (uint64_t k = 0; k < mutations && !HasFailure(); ++k) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", recording " + std::to_string(k));
    uint64_t counter = k * 64;
    const auto below = [&](size_t limit) { return static_cast<size_t>(random.bits(counter++) % limit); };
    std::string bytes = whole[k % whole.size()];
    for (size_t changes = 1 + below(3); changes > 0; --changes) {
      // Half of the damage is in the first bytes of a chunk, where the lengths are.
      const size_t at = below(2) ? below(bytes.size()) : below(std::min<size_t>(bytes.size(), 5000));
      if (below(4) == 0) {
        bytes.erase(at, 1 + below(50));
      } else if (below(3) == 0) {
        bytes[at] = static_cast<char>(below(2) ? 0xff : 0x7f);
      } else {
        bytes[at] ^= static_cast<char>(1 << below(8));
      }
    }
    if (below(10) == 0) bytes.resize(1 + below(bytes.size()));
    try {
      const ImportSummary summary = import(written("damaged", bytes));
      EXPECT_LE(summary.pairs, 2 * static_cast<int64_t>(pairs_.size()));
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("damaged"), std::string::npos);
      ++refused;
    } catch (const std::exception& error) {
      ADD_FAILURE() << "no sentence for users: " << error.what();
    }
  }
  EXPECT_GT(refused, mutations / 20) << "most damage to lengths is noticed";
  RecordProperty("refused", static_cast<int>(refused));
}

}  // namespace
}  // namespace multireach
