#include "vision/track/frame_watch.hpp"

#include <cmath>

namespace multireach::vision {
namespace {

constexpr int64_t kFrozen = 5;  // images in a row

}  // namespace

void FrameWatch::take(int64_t left, int64_t right) {
  const std::array<int64_t, 2> now{left, right};
  if (now == last_) return;  // the same pair again
  const std::array<bool, 2> same{left == last_[0], right == last_[1]};
  for (size_t side = 0; side < 2; ++side) {
    repeated_[side] = same[side] && !same[1 - side] ? repeated_[side] + 1 : 0;
  }
  last_ = now;
}

std::optional<Side> FrameWatch::frozen() const {
  if (repeated_[0] >= kFrozen) return Side::kLeft;
  if (repeated_[1] >= kFrozen) return Side::kRight;
  return std::nullopt;
}

std::vector<double> FrameWatch::memory() const {
  return {static_cast<double>(last_[0]), static_cast<double>(last_[1]), static_cast<double>(repeated_[0]),
          static_cast<double>(repeated_[1])};
}

bool FrameWatch::restore(std::span<const double> memory) {
  if (memory.size() != kMemory) return false;
  for (const double value : memory) {
    if (!(value >= 0 && value < 9007199254740992.0 && value == std::floor(value))) return false;
  }
  last_ = {static_cast<int64_t>(memory[0]), static_cast<int64_t>(memory[1])};
  repeated_ = {static_cast<int64_t>(memory[2]), static_cast<int64_t>(memory[3])};
  return true;
}

}  // namespace multireach::vision
