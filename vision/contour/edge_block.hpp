#pragma once

#include <array>
#include <cstdint>

#include "numeric/rows.hpp"
#include "vision/contour/edge_profile.hpp"

namespace multireach::vision {

/// Edges that are computed together, one in each lane.
struct EdgeBlock {
  int half = 2;            ///< of all windows
  int begin = 0, end = 0;  ///< the pixels in use, from inside to outside, relative to the middle one
  int count = 0;           ///< of the lanes in use
  Row at, middle, outward, along_row, cosine, normal_x, normal_y;
  std::array<std::array<Row, 3>, 2 * EdgeProfile::kReach + 1> bgr;  ///< from inside to outside

  uint32_t marked = 0;  ///< a bit for each lane that has an edge (measure_edges), or paint (mark_painted)
  // What measure_edges() computes where there is an edge.
  Row found_at, sigma_px, shading_px;
  std::array<Row, Shading::kTerms> shading_terms;
  std::array<Row, 3> shading_gain, rim, background;

  Row colour_blur2, luma_blur2, luma_share;  ///< what measure_blur() computes

  /// What read_surface() computes: the terms of the surface's normals at every second pixel, from the innermost.
  std::array<std::array<Row, Shading::kTerms>, EdgeProfile::kReach / 2> surface_terms;
  /// How far inside of the middle one the pixel of surface_terms[i] is.
  static constexpr int pixels_inside(size_t i) { return EdgeProfile::kReach - 2 * static_cast<int>(i); }

  void set(int lane, const Edgel& edgel, const EdgeProfile& profile) {
    at[lane] = edgel.at;
    middle[lane] = profile.middle;
    outward[lane] = edgel.outward;
    along_row[lane] = edgel.along_row ? 1 : 0;
    cosine[lane] = edgel.cosine;
    normal_x[lane] = edgel.normal.x();
    normal_y[lane] = edgel.normal.y();
    for (int k = begin; k < end; ++k) {
      const auto i = static_cast<size_t>(EdgeProfile::kReach + k);
      for (size_t channel = 0; channel < 3; ++channel) bgr[i][channel][lane] = profile.bgr[i][channel];
    }
  }
  /// Gives the lanes that are not in use the numbers of the first.
  void fill_up() {
    for (int lane = count; lane < kRowLanes; ++lane) {
      for (Row* row : {&at, &middle, &outward, &along_row, &cosine, &normal_x, &normal_y}) (*row)[lane] = (*row)[0];
      for (int k = begin; k < end; ++k) {
        for (Row& row : bgr[static_cast<size_t>(EdgeProfile::kReach + k)]) row[lane] = row[0];
      }
    }
  }
  EdgeBlur blur(int lane) const {
    return {.colour2 = colour_blur2[lane], .luma2 = luma_blur2[lane], .luma_share = luma_share[lane]};
  }
  SurfaceColour surface_colour(size_t i, int lane) const {
    SurfaceColour colour;
    for (size_t k = 0; k < Shading::kTerms; ++k) colour.numbers[k] = surface_terms[i][k][lane];
    const auto& pixel = bgr[static_cast<size_t>(EdgeProfile::kReach - pixels_inside(i))];
    for (size_t k = 0; k < 3; ++k) colour.numbers[Shading::kTerms + k] = pixel[k][lane];
    return colour;
  }
  Edge edge(int lane) const {
    Edge edge{.at = found_at[lane], .sigma_px = sigma_px[lane], .shading_px = shading_px[lane]};
    for (int k = 0; k < Shading::kTerms; ++k) edge.shading_terms[k] = shading_terms[static_cast<size_t>(k)][lane];
    for (int k = 0; k < 3; ++k) {
      const auto channel = static_cast<size_t>(k);
      edge.shading_gain[k] = shading_gain[channel][lane];
      edge.rim[k] = rim[channel][lane];
      edge.background[k] = background[channel][lane];
    }
    return edge;
  }
};

}  // namespace multireach::vision
