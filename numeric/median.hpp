#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace multireach {

/// Median of values, of which there is one at least, and the upper one of two. Changes their order.
inline double median_of(std::span<double> values) {
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace multireach
