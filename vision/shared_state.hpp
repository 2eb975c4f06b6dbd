#pragma once

#include <span>
#include <vector>

#include "vision/camera_check/frozen_frame_detector.hpp"

namespace multireach::vision {

// The state of a stage that tracks several targets: of each target's `tracker`, followed by what all targets share.

/// The state of one target after a pair at time `utime` (microseconds).
template <class Target>
std::vector<double> serialize_target(const Target& target, const FrozenFrameDetector& shared, int64_t utime) {
  std::vector<double> state = target.tracker.serialize(utime);
  const std::vector<double> of_all = shared.serialize(utime);
  state.insert(state.end(), of_all.begin(), of_all.end());
  return state;
}

/// Restores the states of all targets. Returns false, and changes nothing, when one is not valid.
template <class Target>
[[nodiscard]] bool deserialize_targets(int64_t utime, const std::vector<std::span<const double>>& states,
                                       std::vector<Target>& targets, FrozenFrameDetector& shared) {
  if (states.size() != targets.size()) return false;
  FrozenFrameDetector of_all;
  std::vector<decltype(targets[0].tracker)> trackers;
  for (size_t k = 0; k < states.size(); ++k) {
    if (states[k].size() < FrozenFrameDetector::kSerializedSize) return false;
    const size_t own = states[k].size() - FrozenFrameDetector::kSerializedSize;
    trackers.push_back(targets[k].tracker);
    if (!trackers[k].deserialize(utime, states[k].first(own)) || !of_all.deserialize(utime, states[k].subspan(own)))
      return false;
  }
  for (size_t k = 0; k < trackers.size(); ++k) targets[k].tracker = std::move(trackers[k]);
  shared = of_all;
  return true;
}

}  // namespace multireach::vision
