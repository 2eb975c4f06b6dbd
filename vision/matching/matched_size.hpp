#pragma once

#include "vision/tracked_object.hpp"
#include "vision/tracker_options.hpp"
#include "vision/view.hpp"

namespace multireach::vision {

// How large a matched object is, by its contours in the two views that were matched.

/// Whether the areas of a match tell how large an object of unknown size is.
[[nodiscard]] bool tells_size(const TrackerOptions& options, const StereoMatch& match, const View& left,
                              const View& right);

/// Radius of a disc of the matched object's area, m, in the image where it is smaller.
double radius_by_area(const StereoRig& rig, const StereoMatch& match, const View& left, const View& right);

/// Adds what may be occluded to the covariance of a match by the area of an object of unknown size at the time of the
/// pair, `utime` (us).
void add_occlusion(const TrackerOptions& options, const UnoccludedSize& size, int64_t utime, const View& left,
                   const View& right, StereoMatch& match);

/// Whether a match has a position.
[[nodiscard]] bool has_position(StereoMatch::Status status);

}  // namespace multireach::vision
