#pragma once

#include <cstddef>
#include <vector>

#include "vision/contour/contour_polygon.hpp"
#include "vision/contour/edge_profile.hpp"

namespace multireach::vision {

/// One point of a sphere contour where an edge is searched for, and the result.
struct ContourEdgel {
  Edgel edge;
  double expected = 0;    ///< where the edge is expected: `edge.at` before it is looked for nearby
  size_t part = 0;        ///< its side of the polygon
  double length = 0;      ///< of the contour that it represents, pixels
  size_t profile = 0;     ///< index among the profiles
  bool readable = false;  ///< its profile lies inside the image
  bool painted = false;   ///< the surface beside it has another colour than most of it
  int half = 2;           ///< the window is 2 half + 1 pixels wide, at most EdgeModel::kWidestHalf
  bool is_edge = false;   ///< there is an edge, `found`
  Edge found;
  EdgeBlur blur;   ///< set by measure_blur()
  int point = -1;  ///< index among the contour's points; -1: no edge found
};

/// Sets `edgels`, in order along the contour, to where a polygon crosses rows (where it is steep) and columns (where it
/// is flat): every row or column, or every second, third ... of a contour with more than about
/// `most`; at most kMaxContourPoints of them.
void place_edgels(const ContourPolygon& polygon, double radius_px, int most, std::vector<ContourEdgel>& edgels);

}  // namespace multireach::vision
