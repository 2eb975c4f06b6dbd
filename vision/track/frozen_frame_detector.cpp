#include "vision/track/frozen_frame_detector.hpp"

#include <cmath>

namespace multireach::vision {
namespace {

constexpr int64_t kFrozen = 5;  // consecutive repetitions that count as frozen

}  // namespace

void FrozenFrameDetector::update(int64_t left, int64_t right) {
  const std::array<int64_t, 2> now{left, right};
  if (now == last_) return;  // both sides repeat, e.g. the same pair received again
  const std::array<bool, 2> same{left == last_[0], right == last_[1]};
  for (size_t side = 0; side < 2; ++side) {
    repeated_[side] = same[side] && !same[1 - side] ? repeated_[side] + 1 : 0;
  }
  last_ = now;
}

std::optional<Side> FrozenFrameDetector::repeats() const {
  if (repeated_[0] > 0) return Side::kLeft;
  if (repeated_[1] > 0) return Side::kRight;
  return std::nullopt;
}

const char* FrozenFrameDetector::fault() const {
  const auto side = repeats();
  if (!side) return nullptr;
  const bool left = *side == Side::kLeft;
  if (repeated_[left ? 0 : 1] < kFrozen)
    return left ? "the left camera repeats its last image" : "the right camera repeats its last image";
  return left ? "the left camera is frozen: it repeats the same image"
              : "the right camera is frozen: it repeats the same image";
}

std::vector<double> FrozenFrameDetector::serialize() const {
  return {static_cast<double>(last_[0]), static_cast<double>(last_[1]), static_cast<double>(repeated_[0]),
          static_cast<double>(repeated_[1])};
}

bool FrozenFrameDetector::deserialize(std::span<const double> state) {
  if (state.size() != kSerializedSize) return false;
  for (const double value : state) {
    if (!(value >= 0 && value < 9007199254740992.0 && value == std::floor(value))) return false;
  }
  last_ = {static_cast<int64_t>(state[0]), static_cast<int64_t>(state[1])};
  repeated_ = {static_cast<int64_t>(state[2]), static_cast<int64_t>(state[3])};
  return true;
}

}  // namespace multireach::vision
