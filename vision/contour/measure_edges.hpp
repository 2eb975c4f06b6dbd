#pragma once

#include <span>
#include <vector>

#include "vision/contour/contour_edgel.hpp"
#include "vision/contour/edge_profile.hpp"

namespace multireach::vision {

// Several edges at a time, in SIMD lanes. Every operation follows IEEE 754 in each lane, so the results do not depend
// on the instruction set.

/// Measures the edges of the edgels `which` (indices) in their profiles by the partial-area principle: the object's
/// shares of the pixels across the edge add up to the length of the object's part. Unbiased for pixels that average
/// over their area and for any symmetric blur narrower than the window. Where the blur is known (`model.blur2`), least
/// squares then fits an edge of that blur to the pixels that it touches, which excludes the noise of the others. The
/// colours of both sides are taken next to the window and extrapolated to the edge: inside by `shading`, outside by the
/// background's slope. They are compared along the most discriminative direction in colour space, given that brightness
/// at the rim is less certain than hue. Sets `is_edge` and, where it is true, `found`; it is false when there is no
/// edge near the expected position.
void measure_edges(std::span<const int> which, std::span<const EdgeProfile> profiles, const EdgeModel& model,
                   const Shading& shading, std::span<ContourEdgel> edgels);

/// Measures the blur of the edgels `which` in windows of five pixels.
void measure_blur(std::span<const int> which, std::span<const EdgeProfile> profiles, std::span<ContourEdgel> edgels);

/// Sets `surface` to every second pixel inside the windows of the edgels `which`, in their order.
void read_surface(std::span<const int> which, std::span<const EdgeProfile> profiles, double radius_px,
                  std::span<ContourEdgel> edgels, std::vector<SurfaceColour>& surface);

/// Marks those of the edgels `which` beside which the surface's colour differs from `shading`, which is known, by more
/// than `most` grey levels.
void mark_painted(std::span<const int> which, std::span<const EdgeProfile> profiles, const Shading& shading,
                  double radius_px, double most, std::span<ContourEdgel> edgels);

}  // namespace multireach::vision
