#include "studies/study/shard_progress.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "runtime/files.hpp"
#include "runtime/message_clock.hpp"
#include "tests/temporary_folder.hpp"

namespace multireach {
namespace {

class Shards : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const { write_text_file(at(name), text); }
  std::string at(const std::string& name) const { return folder_ / name; }
  std::string line(int64_t now_us = 0) const { return shard_status(folder_.path(), now_us).line; }

  const testing::TemporaryFolder folder_;
};

TEST_F(Shards, OneLineTellsDoneRunningSilentAndNotBegun) {
  write("shard0.json", R"({"shard": "0/4", "results": []})");
  // Half of its part in 10 s, so another 10 s for it, and 20 for the one that has not begun.
  write("shard1.json.progress", R"({"shard": "1/4", "part": 0.5, "seconds": 10, "utime": 1000000})");
  write("study.json", R"({"shard": "0/1"})");
  write("other.json", "[1]");
  EXPECT_EQ(line(2000000), "4 shards: 1 done, 1 running, 2 not begun; 38 %, 50 s left");
  EXPECT_EQ(line(62000000),
            "4 shards: 1 done, 0 running, 2 not begun, 1 silent for over a minute (1): run them again; 38 %");
  EXPECT_FALSE(shard_status(folder_.path(), 0).done);
  for (int k = 1; k < 4; ++k)
    write("shard" + std::to_string(k) + ".json", R"({"shard": ")" + std::to_string(k) + R"(/4"})");
  EXPECT_EQ(line(), "4 shards: 4 done, 0 running, 0 not begun; 100 %") << "a result counts, not what is left beside it";
  EXPECT_TRUE(shard_status(folder_.path(), 0).done);
}

TEST_F(Shards, ARunningShardWritesAFileThatIsGoneWhenItIsDone) {
  {
    const ShardProgress progress(at("shard2.json"), {2, 3});
    EXPECT_EQ(line(wall_us()), "3 shards: 0 done, 1 running, 2 not begun; 0 %");
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(Shards, FoldersThatAreNoStudyAreRefused) {
  EXPECT_THROW(line(), InputError);
  EXPECT_THROW(shard_status(at("nowhere"), 0), InputError);
  write("a.json", R"({"shard": "0/4"})");
  write("b.json", R"({"shard": "0/5"})");
  EXPECT_THROW(line(), InputError) << "of two studies";
  write("b.json.progress", "nonsense");
  EXPECT_THROW(line(), InputError);
}

}  // namespace
}  // namespace multireach
