#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "runtime/shard.hpp"

namespace multireach {

/// What a running shard says of itself, about once a second, in a file beside its result: RESULT.progress. The file is
/// removed once the shard is done; one that stays and is not written any more is of a shard that was killed.
class ShardProgress {
 public:
  /// `result`: where the shard's result will be. Throws InputError or OutputError when no file can be written there.
  ShardProgress(const std::string& result, const Shard& shard);
  ~ShardProgress();
  ShardProgress(const ShardProgress&) = delete;
  ShardProgress& operator=(const ShardProgress&) = delete;

  /// `part`: 0 to 1. Cheap to call.
  void show(double part);

 private:
  void write(double part) const;

  std::string path_;
  Shard shard_;
  std::chrono::steady_clock::time_point begin_, last_;
};

struct ShardStatus {
  std::string line;   ///< of all shards
  bool done = false;  ///< all of them
};

/// Reads the results and the progress files of one study in `folder`. `now_us`: wall time. Throws InputError when there
/// are none, or of several studies.
ShardStatus shard_status(const std::string& folder, int64_t now_us);

}  // namespace multireach
