#pragma once

#include "vision/stereo_vision.hpp"

namespace multireach::vision {

// Targets that look alike are solid: they cannot go through each other.

/// Whether two targets would go through each other on their ways from where they were seen last to these matches.
bool pass_through(const StereoVision::Target& a, const StereoMatch& match_a, const StereoVision::Target& b,
                  const StereoMatch& match_b);

/// Whether two targets cannot both keep their motion until `utime` (microseconds), because they would go through each
/// other. Their bias does not count: with it, targets that are measured by centroids would never be said to.
bool would_bounce(const StereoVision::Target& a, const StereoVision::Target& b, int64_t utime);

}  // namespace multireach::vision
