#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "runtime/config.hpp"
#include "runtime/shard.hpp"
#include "tools/log/run_report.hpp"
#include "tools/replay/run.hpp"

namespace multireach {

/// A key of robot.yaml or vision.yaml, and the values that it takes in a sweep.
struct SweptKey {
  std::string key;
  std::vector<std::string> values;  ///< in YAML
};

/// "KEY=V1,V2,..." as given to --set; commas inside of brackets and quotes belong to a value. Throws InputError.
SweptKey swept_key_from(const std::string& text);

/// All combinations of the values of some keys. They are numbered from 0; the last key's value changes fastest.
class SweepGrid {
 public:
  /// Throws InputError for a key that is given twice, or inside of another, and for more than a million combinations.
  explicit SweepGrid(std::vector<SweptKey> keys);

  const std::vector<SweptKey>& keys() const { return keys_; }
  int64_t size() const { return size_; }
  ConfigOverrides overrides(int64_t combination) const;

 private:
  std::vector<SweptKey> keys_;
  int64_t size_ = 1;
};

/// A sweep's replays. `options` is called from one thread at a time and throws InputError for values that are wrong.
struct SweepJob {
  SweepGrid grid;
  std::function<ReplayOptions(const ConfigOverrides&)> options;
  Shard shard{};
  int jobs = 1;  ///< replays at the same time
};

/// Loads the configuration of every combination of the shard, as its replay will. Throws InputError for the first one
/// that is wrong.
void check_sweep(const SweepJob& job);

/// Replays every combination of the shard. Returns one row for each, in the order of their numbers: `index`, `set` (the
/// keys' values), `figures` (of the report on the run, and the digest of all computed messages). The rows do not depend
/// on `jobs`. Throws InputError when the session cannot be read.
nlohmann::ordered_json sweep_rows(const SweepJob& job, const ReplayProgress& progress);

/// The figures of the report on one run, as in the columns of a sweep's table, without the digest.
nlohmann::ordered_json figures_of(const RunReport& run);

/// A sweep as a table: a row for each combination, a column for its number, for each key and for each figure. Throws
/// nlohmann::json::exception where `sweep`, an object with `rows`, has another form.
std::string sweep_table(const nlohmann::ordered_json& sweep);

/// The whole sweep from the results of all its shards, which were read from `paths`; the same bytes as those of one
/// that was not divided. Throws InputError for shards that are missing, repeated, or of another sweep.
nlohmann::ordered_json merged_sweep(const std::vector<std::string>& paths);

}  // namespace multireach
