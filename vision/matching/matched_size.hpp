#pragma once

#include "vision/matching/pair_context.hpp"
#include "vision/stereo/stereo_match.hpp"

namespace multireach::vision {

// How large a matched object is, by its contours in the two views.

/// Whether the areas of a match tell how large an object of unknown size is.
[[nodiscard]] bool tells_size(const PairContext& pair, const StereoMatch& match);

/// Radius of a disc of the matched object's area, m, in the image where it is smaller.
double radius_by_area(const PairContext& pair, const StereoMatch& match);

/// Adds to `match.shape_covariance`, m^2, what may be occluded of an object of unknown size, or, with the wider
/// colours, what may be seen beside it. Changes nothing where the border cuts the object off: the match's covariance
/// has that.
void add_occlusion_covariance(const PairContext& pair, StereoMatch& match);

}  // namespace multireach::vision
