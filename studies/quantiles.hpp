#pragma once

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

namespace multireach {

/// The values at the quantiles of a sample: the smallest value such that at least this share is not above it; null
/// where there are no values.
inline nlohmann::json quantiles(std::vector<double> values) {
  nlohmann::json result;
  std::ranges::sort(values);
  for (const auto& [name, share] : {std::pair("p50", 0.5), {"p90", 0.9}, {"p95", 0.95}, {"p99", 0.99}}) {
    if (values.empty()) {
      result[name] = nullptr;
      continue;
    }
    const auto at = static_cast<size_t>(std::max(0.0, std::ceil(share * static_cast<double>(values.size())) - 1));
    result[name] = values[at];
  }
  return result;
}

}  // namespace multireach
