#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "imaging/side.hpp"

namespace multireach::vision {

/// Tells a camera that gives the same image again and again while the other one goes on. No sensor gives the same bytes
/// twice; a recording that is a still picture does so on both sides.
class FrameWatch {
 public:
  /// Numbers that tell the bytes of this pair's images from others: whole numbers below 2^53.
  void take(int64_t left, int64_t right);
  std::optional<Side> frozen() const;

  /// All that it remembers, so that another one can go on from here.
  std::vector<double> memory() const;
  /// Returns false, and changes nothing, when `memory` is none.
  bool restore(std::span<const double> memory);

  static constexpr size_t kMemory = 4;

 private:
  std::array<int64_t, 2> last_{};
  std::array<int64_t, 2> repeated_{};
};

}  // namespace multireach::vision
