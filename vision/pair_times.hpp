#pragma once

#include <cstdint>
#include <cstdlib>

namespace multireach::vision {

/// Capture times of a stereo pair, microseconds.
struct PairTimes {
  int64_t pair = 0;  ///< nominal time of the pair
  int64_t left = 0, right = 0;
};

/// Time of an image relative to its pair's, s; 0 when the image's time is implausible, 0.2 s or more from the pair's.
inline double offset_s(int64_t image, int64_t pair) {
  constexpr int64_t kFarApart = 200000;  // us
  const int64_t offset = image - pair;
  return std::abs(offset) <= kFarApart ? static_cast<double>(offset) * 1e-6 : 0;
}

}  // namespace multireach::vision
