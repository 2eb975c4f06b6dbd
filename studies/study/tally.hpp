#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <utility>

#include "studies/study/run_reach.hpp"

namespace multireach {

/// Counts of values in bins, so that shards of a study can be added up and give what one run would have given.
class Histogram {
 public:
  void add(int64_t bin, int64_t count = 1) { counts_[bin] += count; }
  void merge(const Histogram& other) {
    for (const auto& [bin, count] : other.counts_) counts_[bin] += count;
  }
  /// The smallest bin that at least the fraction `p` of all values is not above; nothing when there are none.
  std::optional<int64_t> quantile(double p) const;
  const std::map<int64_t, int64_t>& counts() const { return counts_; }

 private:
  std::map<int64_t, int64_t> counts_;
};

/// What came out of the reaches of one gamma. Sums of whole numbers and largest values only: the order of the reaches
/// makes no difference.
struct Tally {
  double gamma = 0;
  int64_t samples = 0, failures = 0, limit_violations = 0, velocity_violations = 0, nonfinite = 0, steps_total = 0;
  double max_error_m = 0;                                // of the reaches that ended finite
  double max_limit_excess = 0, max_velocity_excess = 0;  // of the same
  int64_t first_failure = -1;                            // the smallest index of a reach that failed
  Histogram path_ratio{};                                // kRatioBins for 1; reaches over kShortest only
  Histogram settle_steps{};                              // of all reaches; those that never settled last
  double seconds = 0;                                    // of computing, summed over threads

  static constexpr double kRatioBins = 1000;
  static constexpr double kShortest = 0.01;  // m: the ratio of a shorter reach says little

  /// Wilson's 95 % interval of the ratio of failures; 0 to 1 for no samples.
  std::pair<double, double> failure_interval() const;
  void add(int64_t index, const ReachResult& reach, const ReachRules& rules);
  void merge(const Tally& other);
  nlohmann::json json(const ReachRules& rules) const;
  /// The counts behind the quantiles; a shard's file has them as "histograms", for from_json.
  nlohmann::json histograms() const;
  static Tally from_json(const nlohmann::json& json);
};

}  // namespace multireach
