#pragma once

#include <cstddef>

namespace multireach {

/// Side of a stereo pair.
enum class Side { kLeft, kRight };

/// 0 for the left, 1 for the right side.
constexpr size_t index(Side side) {
  return side == Side::kLeft ? 0 : 1;
}

}  // namespace multireach
