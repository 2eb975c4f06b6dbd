// What a tracker carries from one pair to the next, as numbers.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "vision/packed_cells.hpp"
#include "vision/stereo_tracker.hpp"

namespace multireach::vision {

std::vector<double> StereoTracker::serialize(int64_t utime) const {
  std::vector<double> state = track_.serialize();
  for (const CameraState& camera_state : cameras_) {
    append_packed(camera_state.background.cells(), state);
    append_packed(camera_state.motion.cells(), state);
    state.insert(state.end(), {static_cast<double>(camera_state.looks), static_cast<double>(camera_state.since_look)});
  }
  const std::vector<double> identity = identity_.serialize(utime);
  state.insert(state.end(), identity.begin(), identity.end());
  state.push_back(static_cast<double>(track_.utime() - utime));
  const double unoccluded_m = unoccluded_size_.radius_m();
  const int64_t measured = unoccluded_m > 0 ? unoccluded_size_.utime() - utime : 0;
  state.insert(state.end(), {radius_m_, unoccluded_m, static_cast<double>(measured)});
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column <= row; ++column) state.push_back(shape_covariance_(row, column));
  }
  for (const CameraState& camera_state : cameras_)
    state.insert(state.end(), {camera_state.gains.red, camera_state.gains.blue});
  return state;
}

bool StereoTracker::deserialize(int64_t utime, std::span<const double> state) {
  constexpr size_t kOwn = 14, kIdentity = TargetIdentity::kSerializedSize;
  constexpr double kLongest = 9e15;  // us; a double represents integers up to here exactly
  constexpr size_t kLooks = 2;       // numbers of looks, after each background
  std::array<size_t, 2> backgrounds{}, pictures{};
  size_t besides = kIdentity + kOwn;
  for (size_t side = 0; side < 2; ++side) {
    backgrounds[side] = packed_size(cameras_[side].background.cells().size());
    pictures[side] = packed_size(cameras_[side].motion.cells().size());
    besides += backgrounds[side] + pictures[side] + kLooks;
  }
  if (state.size() < besides) return false;
  const auto whole = [](double value, double most) {
    return value >= 0 && value <= most && value == std::floor(value);
  };
  const auto own = state.last(kOwn);
  for (const double time : {own[0], own[3]}) {
    if (!(time >= -kLongest && time <= kLongest && time == std::floor(time))) return false;
  }
  for (const double radius_m : own.subspan(1, 2)) {
    if (!(radius_m >= 0 && radius_m < 1e6)) return false;
  }
  const auto shape = own.subspan(4, 6);  // the lower triangle
  if (!std::ranges::all_of(shape, [](double v) { return std::isfinite(v); })) return false;
  for (const double gain : own.last(4)) {
    if (!(gain >= kMinGain && gain <= kMaxGain)) return false;
  }
  const auto of_track = state.first(state.size() - besides);
  struct OfCamera {
    std::span<const double> background, picture, looks;
  };
  std::array<OfCamera, 2> of_camera;
  size_t at = of_track.size();
  for (size_t side = 0; side < 2; ++side) {
    const auto next = [&](size_t count) { return state.subspan(std::exchange(at, at + count), count); };
    of_camera[side] = {next(backgrounds[side]), next(pictures[side]), next(kLooks)};
    const auto& [background, picture, looks] = of_camera[side];
    if (!is_packed(background, cameras_[side].background.cells().size())) return false;
    if (!is_packed(picture, cameras_[side].motion.cells().size())) return false;
    if (!whole(looks[0], kFirstLooks) || !whole(looks[1], kLookEvery)) return false;
  }
  TargetIdentity identity;
  if (!identity.deserialize(utime, state.subspan(at, kIdentity))) return false;
  if (!track_.deserialize(utime + static_cast<int64_t>(own[0]), of_track)) return false;
  identity_ = identity;
  for (size_t side = 0; side < 2; ++side) {
    CameraState& camera_state = cameras_[side];
    unpack(of_camera[side].background, camera_state.background.cells());
    unpack(of_camera[side].picture, camera_state.motion.cells());
    camera_state.looks = static_cast<int>(of_camera[side].looks[0]);
    camera_state.since_look = static_cast<int>(of_camera[side].looks[1]);
  }
  radius_m_ = own[1];
  unoccluded_size_.set_state(own[2], utime + static_cast<int64_t>(own[3]));
  for (int row = 0, k = 0; row < 3; ++row) {
    for (int column = 0; column <= row; ++column)
      shape_covariance_(row, column) = shape_covariance_(column, row) = shape[static_cast<size_t>(k++)];
  }
  cameras_[0].gains = {own[10], own[11]};
  cameras_[1].gains = {own[12], own[13]};
  return true;
}

}  // namespace multireach::vision
