#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <utility>

#include "studies/study/run_reach.hpp"

namespace multireach {

/// Counts of values in bins. Merging the shards of a study gives the same counts as a single run.
class Histogram {
 public:
  void add(int64_t bin, int64_t count = 1) { counts_[bin] += count; }
  void merge(const Histogram& other) {
    for (const auto& [bin, count] : other.counts_) counts_[bin] += count;
  }
  /// The smallest bin such that at least the fraction `p` of all values is in it or below; nullopt when empty.
  std::optional<int64_t> quantile(double p) const;
  const std::map<int64_t, int64_t>& counts() const { return counts_; }

 private:
  std::map<int64_t, int64_t> counts_;
};

/// The results of all reaches under one gamma. It holds only integer sums and maxima, so the order of the reaches does
/// not matter (except for `seconds`).
struct Tally {
  double gamma = 0;
  int64_t samples = 0, failures = 0, limit_violations = 0, velocity_violations = 0, nonfinite = 0, steps_total = 0;
  double max_error_m = 0;                                // over the reaches that stayed finite
  double max_limit_excess = 0, max_velocity_excess = 0;  // over the reaches that stayed finite
  int64_t first_failure = -1;                            // smallest index of a failed reach; -1 for none
  Histogram path_ratio{};                                // ratio * kRatioBins; only for distances over kMinDistance
  Histogram settle_steps{};                              // all reaches; those that never settled are in the last bin
  double seconds = 0;                                    // computing time, summed over threads

  static constexpr double kRatioBins = 1000;
  static constexpr double kMinDistance = 0.01;  // m: the path ratio of a shorter reach is not meaningful

  /// Wilson's 95 % confidence interval of the failure ratio; (0, 1) without samples.
  std::pair<double, double> failure_interval() const;
  void add(int64_t index, const ReachResult& reach, const ReachRules& rules);
  void merge(const Tally& other);
  nlohmann::json json(const ReachRules& rules) const;
  /// The histograms behind the quantiles; a shard's JSON file stores them as "histograms", which from_json() reads.
  nlohmann::json histograms() const;
  static Tally from_json(const nlohmann::json& json);
};

}  // namespace multireach
