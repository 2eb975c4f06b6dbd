// What a tracker carries from one pair to the next, as numbers.
#include <algorithm>
#include <array>
#include <cmath>

#include "vision/stereo_tracker.hpp"

namespace multireach::vision {

std::vector<double> StereoTracker::serialize(int64_t utime) const {
  std::vector<double> state = object_.track.serialize();
  for (const ObjectDetector& detector : detectors_) detector.append_serialized(state);
  const std::vector<double> identity = object_.identity.serialize(utime);
  state.insert(state.end(), identity.begin(), identity.end());
  state.push_back(static_cast<double>(object_.track.utime() - utime));
  const UnoccludedSize& unoccluded = object_.unoccluded_size;
  const int64_t measured = unoccluded.radius_m() > 0 ? unoccluded.utime() - utime : 0;
  state.insert(state.end(), {object_.radius_m, unoccluded.radius_m(), static_cast<double>(measured)});
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column <= row; ++column) state.push_back(object_.shape_covariance(row, column));
  }
  for (const ObjectDetector& detector : detectors_)
    state.insert(state.end(), {detector.gains().red, detector.gains().blue});
  return state;
}

bool StereoTracker::deserialize(int64_t utime, std::span<const double> state) {
  constexpr size_t kOwn = 14, kIdentity = TargetIdentity::kSerializedSize;
  constexpr double kLongest = 9e15;  // us; a double represents integers up to here exactly
  const size_t of_left = detectors_[0].serialized_size(), of_right = detectors_[1].serialized_size();
  const size_t besides = of_left + of_right + kIdentity + kOwn;
  if (state.size() < besides) return false;
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
  const std::array of_detectors{state.subspan(of_track.size(), of_left),
                                state.subspan(of_track.size() + of_left, of_right)};
  for (size_t side = 0; side < 2; ++side) {
    if (!detectors_[side].is_valid_state(of_detectors[side])) return false;
  }
  TargetIdentity identity;
  if (!identity.deserialize(utime, state.subspan(of_track.size() + of_left + of_right, kIdentity))) return false;
  if (!object_.track.deserialize(utime + static_cast<int64_t>(own[0]), of_track)) return false;
  object_.identity = identity;
  object_.radius_m = own[1];
  object_.unoccluded_size.set_state(own[2], utime + static_cast<int64_t>(own[3]));
  for (int row = 0, k = 0; row < 3; ++row) {
    for (int column = 0; column <= row; ++column)
      object_.shape_covariance(row, column) = object_.shape_covariance(column, row) = shape[static_cast<size_t>(k++)];
  }
  for (size_t side = 0; side < 2; ++side) {
    detectors_[side].deserialize(of_detectors[side]);
    detectors_[side].set_gains({own[10 + 2 * side], own[11 + 2 * side]});
  }
  return true;
}

}  // namespace multireach::vision
