#pragma once

#include <span>

#include "bench/real/real_set.hpp"

namespace multireach::bench {

/// Tracks each object of videos of two cameras, with colours from clicks in both images, and prints how far the answers
/// are from the labels: in the images, and in space from the labels' triangulation, beside the OpenCV baseline.
/// `clicks`: at most so many of an object's clicks, evenly spread; `together`: one colour from all that are taken;
/// `refused`: also with colours that `calibrate colour` refuses; `each`: a line for each answer.
void print_stereo_videos(std::span<const RealSet> videos, int clicks, bool together, bool refused, bool each);

}  // namespace multireach::bench
