#include "vision/camera_check/frozen_frame_detector.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::vision {
namespace {

constexpr double kLargest = 9007199254740992.0;  // 2^53: a double represents integers up to here exactly
constexpr int64_t kFrozen = 5;                   // consecutive repetitions that count as frozen

}  // namespace

void FrozenFrameDetector::update(const Image& left, const Image& right) {
  const std::array<Image, 2> now{left, right};
  const std::array<bool, 2> same{left.hash == last_[0].hash, right.hash == last_[1].hash};
  for (size_t side = 0; side < 2; ++side) {
    if (!(same[0] && same[1])) repeated_[side] = same[side] ? repeated_[side] + 1 : 0;
    as_new_[side] = repeated_[side] > 0 && now[side].utime != last_[side].utime;
  }
  const bool as_new = left.utime != last_[0].utime && right.utime != last_[1].utime;
  if (!(same[0] && same[1]))
    both_repeated_ = 0;
  else if (as_new)
    ++both_repeated_;
  last_ = now;
}

std::optional<Side> FrozenFrameDetector::repeats() const {
  for (const Side side : {Side::kLeft, Side::kRight}) {
    if (as_new_[index(side)] || repeated_[index(side)] >= kFrozen) return side;
  }
  return std::nullopt;
}

const char* FrozenFrameDetector::fault() const {
  const auto side = repeats();
  if (!side) return nullptr;
  const bool left = *side == Side::kLeft;
  if (repeated_[index(*side)] < kFrozen)
    return left ? "the left camera repeats its last image as a new one"
                : "the right camera repeats its last image as a new one";
  return left ? "the left camera is frozen: it repeats the same image"
              : "the right camera is frozen: it repeats the same image";
}

bool FrozenFrameDetector::both_repeat() const {
  return both_repeated_ >= kFrozen;
}

std::vector<double> FrozenFrameDetector::serialize(int64_t utime) const {
  const auto number = [](int64_t value) { return static_cast<double>(value); };
  // A time that is by far wrong, as in nanoseconds, is kept as far as the state can tell.
  const auto age = [&](const Image& image) {
    return std::clamp(number(utime) - number(image.utime), -kLargest + 1, kLargest - 1);
  };
  return {number(last_[0].hash), number(last_[1].hash), number(repeated_[0]),
          number(repeated_[1]),  age(last_[0]),         age(last_[1])};
}

bool FrozenFrameDetector::deserialize(int64_t utime, std::span<const double> state) {
  if (state.size() != kSerializedSize) return false;
  for (size_t k = 0; k < state.size(); ++k) {
    const double least = k < 4 ? 0 : -kLargest;
    if (!(state[k] >= least && state[k] < kLargest && state[k] == std::floor(state[k]))) return false;
  }
  for (size_t side = 0; side < 2; ++side) {
    last_[side] = {static_cast<int64_t>(state[side]), utime - static_cast<int64_t>(state[4 + side])};
    repeated_[side] = static_cast<int64_t>(state[2 + side]);
  }
  both_repeated_ = 0;
  return true;
}

}  // namespace multireach::vision
