#pragma once

#include <cstddef>
#include <cstdint>

#include "vision/colour/pixel_class.hpp"

namespace multireach::vision {

/// How many words class_bits() writes for a row.
inline size_t words_for(int pixels) {
  return (static_cast<size_t>(pixels) + 63) / 64;
}

/// One bit for each of `pixels` BGR pixels, whether it is a member: bit i % 64 of word i / 64; bits beyond the last
/// pixel are zero. Reads no byte but the pixels'. Returns the number of members. The same on every instruction set.
int class_bits(const PixelClass& colours, const uint8_t* bgr, int pixels, uint64_t* words);

}  // namespace multireach::vision
