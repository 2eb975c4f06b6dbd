#pragma once

namespace multireach {

/// Side of a stereo pair.
enum class Side { kLeft, kRight };

constexpr int index(Side side) {
  return side == Side::kLeft ? 0 : 1;
}

}  // namespace multireach
