#pragma once

#include "vision/track/pair_times.hpp"
#include "vision/track/tracked_object.hpp"
#include "vision/track/tracker_options.hpp"
#include "vision/track/view.hpp"

namespace multireach::vision {

/// What the steps of matching work on: one pair of images, and what is known of the object before it.
struct PairContext {
  const TrackerOptions& options;
  const TrackedObject& object;
  PairTimes times;
  const View &left, &right;
};

}  // namespace multireach::vision
