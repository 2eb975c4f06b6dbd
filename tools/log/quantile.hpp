#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace multireach {

/// The value below which this part of the values lies, 0 to 1, interpolated between neighbours; NaN without values.
inline double quantile(std::vector<double> values, double part) {
  if (values.empty()) return NAN;
  std::ranges::sort(values);
  const double at = part * static_cast<double>(values.size() - 1);
  const auto below = static_cast<size_t>(at);
  const size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
}

}  // namespace multireach
