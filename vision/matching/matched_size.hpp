#pragma once

#include "vision/matching/pair_context.hpp"
#include "vision/stereo/stereo_match.hpp"

namespace multireach::vision {

// How large a matched object is, by its contours in the two views.

/// Whether the areas of a match tell how large an object of unknown size is.
[[nodiscard]] bool tells_size(const PairContext& pair, const StereoMatch& match);

/// Whether only the wider colours show all of a matched object, in one of the images.
[[nodiscard]] bool shows_more_than_learned(const PairContext& pair, const StereoMatch& match);

/// Which pixels of an object count: all of its blob, or those that have the learned colours.
enum class Shown { kAll, kByLearnedColours };
/// Radius of a disc of the area that the matched object shows, m, in the image where it is smaller.
double radius_by_area(const PairContext& pair, const StereoMatch& match, Shown shown = Shown::kAll);

/// Adds to `match.shape_covariance`, m^2, what may be occluded of an object of unknown size, and what may be seen
/// beside it, with wider colours or where it is suddenly larger. Changes nothing where the border cuts the object off:
/// the match's covariance has that.
void add_occlusion_covariance(const PairContext& pair, StereoMatch& match);

}  // namespace multireach::vision
