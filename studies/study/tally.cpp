#include "studies/study/tally.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace multireach {
namespace {

using nlohmann::json;

/// The bin of reaches that never settled. A quantile in this bin is reported as null.
constexpr int64_t kNever = INT64_MAX;

json bins(const Histogram& histogram) {
  json list = json::array();
  for (const auto& [bin, count] : histogram.counts()) list.push_back({bin, count});
  return list;
}

Histogram histogram_from(const json& list) {
  Histogram histogram;
  for (const json& pair : list) histogram.add(pair.at(0).get<int64_t>(), pair.at(1).get<int64_t>());
  return histogram;
}

json quantiles(const Histogram& histogram, double bins_per_unit) {
  const auto value = [&](double p) {
    const auto bin = histogram.quantile(p);
    return bin && *bin != kNever ? json(static_cast<double>(*bin) / bins_per_unit) : json(nullptr);
  };
  return {{"p50", value(0.5)}, {"p95", value(0.95)}};
}

}  // namespace

std::optional<int64_t> Histogram::quantile(double p) const {
  int64_t total = 0, sum = 0;
  for (const auto& [bin, count] : counts_) total += count;
  for (const auto& [bin, count] : counts_) {
    sum += count;
    if (static_cast<double>(sum) >= p * static_cast<double>(total)) return bin;
  }
  return std::nullopt;
}

std::pair<double, double> Tally::failure_interval() const {
  if (samples == 0) return {0, 1};
  constexpr double z = 1.959963984540054;
  const auto n = static_cast<double>(samples);
  const double p = static_cast<double>(failures) / n, spread = z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  const double middle = p + z * z / (2 * n), scale = 1 / (1 + z * z / n);
  return {failures == 0 ? 0 : std::max(0.0, scale * (middle - spread)),
          failures == samples ? 1 : std::min(1.0, scale * (middle + spread))};
}

void Tally::add(int64_t index, const ReachResult& reach, const ReachRules& rules) {
  ++samples;
  steps_total += reach.steps;
  if (!reach.arrived) {
    ++failures;
    if (first_failure < 0 || index < first_failure) first_failure = index;
  }
  limit_violations += reach.limit_excess > rules.excess;
  velocity_violations += reach.velocity_excess > rules.excess;
  if (!reach.finite) {
    ++nonfinite;
    settle_steps.add(kNever);
    return;
  }
  max_error_m = std::max(max_error_m, reach.error_m);
  max_limit_excess = std::max(max_limit_excess, reach.limit_excess);
  max_velocity_excess = std::max(max_velocity_excess, reach.velocity_excess);
  if (reach.distance_m > kMinDistance) {
    path_ratio.add(std::llround(std::min(reach.path_m / reach.distance_m, 1e6) * kRatioBins));
  }
  settle_steps.add(reach.settled_step >= 0 ? reach.settled_step : kNever);
}

void Tally::merge(const Tally& other) {
  samples += other.samples;
  failures += other.failures;
  limit_violations += other.limit_violations;
  velocity_violations += other.velocity_violations;
  nonfinite += other.nonfinite;
  steps_total += other.steps_total;
  max_error_m = std::max(max_error_m, other.max_error_m);
  max_limit_excess = std::max(max_limit_excess, other.max_limit_excess);
  max_velocity_excess = std::max(max_velocity_excess, other.max_velocity_excess);
  if (other.first_failure >= 0 && (first_failure < 0 || other.first_failure < first_failure)) {
    first_failure = other.first_failure;
  }
  path_ratio.merge(other.path_ratio);
  settle_steps.merge(other.settle_steps);
  seconds += other.seconds;
}

json Tally::histograms() const {
  return {{"path_ratio_milli", bins(path_ratio)}, {"settle_steps", bins(settle_steps)}};
}

json Tally::json(const ReachRules& rules) const {
  return {{"gamma", gamma},
          {"samples", samples},
          {"failures", failures},
          {"failure_ratio", samples ? static_cast<double>(failures) / static_cast<double>(samples) : 0.0},
          {"failure_ratio_95", {failure_interval().first, failure_interval().second}},
          {"first_failure", first_failure},
          {"limit_violations", limit_violations},
          {"velocity_violations", velocity_violations},
          {"nonfinite", nonfinite},
          {"max_error_m", max_error_m},
          {"max_limit_excess_rad", max_limit_excess},
          {"max_velocity_excess_rad_s", max_velocity_excess},
          {"path_ratio", quantiles(path_ratio, kRatioBins)},
          {"settle_s", quantiles(settle_steps, rules.steps_per_second)},
          {"steps_total", steps_total},
          {"ns_per_step_per_core", steps_total ? 1e9 * seconds / static_cast<double>(steps_total) : 0.0}};
}

Tally Tally::from_json(const nlohmann::json& json) {
  Tally tally;
  tally.gamma = json.at("gamma");
  tally.samples = json.at("samples");
  tally.failures = json.at("failures");
  tally.first_failure = json.at("first_failure");
  tally.limit_violations = json.at("limit_violations");
  tally.velocity_violations = json.at("velocity_violations");
  tally.nonfinite = json.at("nonfinite");
  tally.max_error_m = json.at("max_error_m");
  tally.max_limit_excess = json.at("max_limit_excess_rad");
  tally.max_velocity_excess = json.at("max_velocity_excess_rad_s");
  tally.steps_total = json.at("steps_total");
  tally.seconds = json.at("ns_per_step_per_core").get<double>() * static_cast<double>(tally.steps_total) * 1e-9;
  tally.path_ratio = histogram_from(json.at("histograms").at("path_ratio_milli"));
  tally.settle_steps = histogram_from(json.at("histograms").at("settle_steps"));
  return tally;
}

}  // namespace multireach
