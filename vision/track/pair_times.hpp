#pragma once

#include <cstdint>
#include <cstdlib>

namespace multireach::vision {

/// Capture times of a stereo pair, microseconds.
struct PairTimes {
  int64_t pair = 0;  ///< nominal time of the pair
  int64_t left = 0, right = 0;
};

/// Whether an image was taken so long before or after its pair, or the other image, that they do not show one scene:
/// more than 0.2 s. A time below 0 means that there is no image; 0 means that its time is not known.
inline bool far_apart(const PairTimes& times) {
  constexpr int64_t kFarApart = 200000;  // us
  const auto far = [](int64_t image, int64_t other) { return image > 0 && std::abs(image - other) > kFarApart; };
  return far(times.left, times.pair) || far(times.right, times.pair) ||
         (times.right > 0 && far(times.left, times.right));
}

/// Time of an image relative to its pair's, s; 0 when the image's time is not known.
inline double offset_s(int64_t image, int64_t pair) {
  return far_apart({pair, image, image}) || image <= 0 ? 0 : static_cast<double>(image - pair) * 1e-6;
}

/// Why a pair is not used.
inline constexpr const char* kNotNewer = "the pair is not newer than the last one";
inline constexpr const char* kFarApartInTime =
    "an image was taken more than 0.2 s before or after the other one, or the time of the pair";

}  // namespace multireach::vision
