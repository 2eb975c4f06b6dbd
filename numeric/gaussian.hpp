#pragma once

#include <cmath>
#include <numbers>

#include "numeric/random.hpp"

namespace multireach {

/// A standard normal number from two uniform ones, whose counters are used up (Box and Muller, 1958). By the C
/// library's logarithm and cosine: other libraries may give another last digit.
inline double gaussian(const CounterRandom& random, uint64_t& counter) {
  const double u = 1 - random.uniform(counter), v = random.uniform(counter + 1);
  counter += 2;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

}  // namespace multireach
