#pragma once

#include "vision/stereo/stereo_match.hpp"

namespace multireach::vision {

/// Compares a contour of the left image with one of the right image: whether they may show the same object, and where
/// it is then. Of the result, `match.left` and `match.right` are not set.
ComparedPair compare_contours(const StereoRig& rig, const SphereContour& left, const SphereContour& right,
                              const std::optional<Prediction>& prediction, const MatchOptions& options);

/// How well the two images of a pair fit each other, by rows and sizes: a log likelihood, up to a constant.
double fit_of(const ComparedPair& pair, const MatchOptions& options);

}  // namespace multireach::vision
