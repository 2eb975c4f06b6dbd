// What a tracker carries from one pair to the next, as numbers.
#include <array>
#include <cmath>

#include "vision/stereo_tracker.hpp"

namespace multireach::vision {

std::vector<double> StereoTracker::serialize(int64_t utime) const {
  std::vector<double> state = track_.serialize();
  for (const CameraState& camera_state : cameras_) {
    camera_state.background.serialize(state);
    state.insert(state.end(), {static_cast<double>(camera_state.looks), static_cast<double>(camera_state.since_look)});
  }
  const std::vector<double> identity = identity_.serialize(utime);
  state.insert(state.end(), identity.begin(), identity.end());
  state.push_back(static_cast<double>(track_.utime() - utime));
  state.push_back(radius_m_);
  for (const CameraState& camera_state : cameras_)
    state.insert(state.end(), {camera_state.gains.red, camera_state.gains.blue});
  return state;
}

bool StereoTracker::deserialize(int64_t utime, std::span<const double> state) {
  constexpr size_t kOwn = 6, kIdentity = TargetIdentity::kSerializedSize;
  constexpr double kLongest = 9e15;  // us; a double represents integers up to here exactly
  constexpr size_t kLooks = 2;       // numbers of looks, after each background
  const std::array sizes{cameras_[0].background.serialized_size(), cameras_[1].background.serialized_size()};
  const size_t besides = sizes[0] + sizes[1] + 2 * kLooks + kIdentity + kOwn;
  if (state.size() < besides) return false;
  const auto whole = [](double value, double most) {
    return value >= 0 && value <= most && value == std::floor(value);
  };
  const auto own = state.last(kOwn);
  if (!(own[0] >= -kLongest && own[0] <= kLongest && own[0] == std::floor(own[0]))) return false;
  if (!(own[1] >= 0 && own[1] < 1e6)) return false;
  for (const double gain : own.last(4)) {
    if (!(gain >= kMinGain && gain <= kMaxGain)) return false;
  }
  const auto of_track = state.first(state.size() - besides);
  std::array<std::span<const double>, 2> backgrounds;
  size_t at = of_track.size();
  for (size_t side = 0; side < 2; at += sizes[side] + kLooks, ++side) {
    backgrounds[side] = state.subspan(at, sizes[side] + kLooks);
    const auto looks = backgrounds[side].last(kLooks);
    if (!cameras_[side].background.valid(backgrounds[side].first(sizes[side]))) return false;
    if (!whole(looks[0], kFirstLooks) || !whole(looks[1], kLookEvery)) return false;
  }
  TargetIdentity identity;
  if (!identity.deserialize(utime, state.subspan(at, kIdentity))) return false;
  if (!track_.deserialize(utime + static_cast<int64_t>(own[0]), of_track)) return false;
  identity_ = identity;
  for (size_t side = 0; side < 2; ++side) {
    cameras_[side].background.deserialize(backgrounds[side].first(sizes[side]));
    cameras_[side].looks = static_cast<int>(backgrounds[side][sizes[side]]);
    cameras_[side].since_look = static_cast<int>(backgrounds[side][sizes[side] + 1]);
  }
  radius_m_ = own[1];
  cameras_[0].gains = {own[2], own[3]};
  cameras_[1].gains = {own[4], own[5]};
  return true;
}

}  // namespace multireach::vision
