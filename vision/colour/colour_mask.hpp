#pragma once

#include <cstddef>
#include <cstdint>

#include "vision/colour/colour_table.hpp"

namespace multireach::vision {

/// Number of words that colour_mask_row() writes for a row.
inline size_t words_for(int pixels) {
  return (static_cast<size_t>(pixels) + 63) / 64;
}

/// Computes the colour mask of a row of BGR pixels: bit i % 64 of word i / 64 tells whether pixel i is in `colours`;
/// bits after the last pixel are zero. Reads only the pixels' bytes. Returns the number of set bits. The result does
/// not depend on the instruction set.
int colour_mask_row(const ColourTable& colours, const uint8_t* bgr, int pixels, uint64_t* words);

}  // namespace multireach::vision
