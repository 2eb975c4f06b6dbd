#pragma once

#include <cstddef>

#include "vision/contour/edge_profile.hpp"

namespace multireach::vision {

/// One place of a sphere contour where an edge is looked for, and what was found there.
struct ContourEdgel {
  Edgel edge;
  size_t part = 0;        ///< its side of the polygon
  double length = 0;      ///< of the contour that it represents, pixels
  size_t profile = 0;     ///< index among the profiles
  bool readable = false;  ///< its profile lies inside the image
  bool painted = false;   ///< the surface beside it has another colour than most of it
  int half = 2;           ///< of the window, see EdgeModel
  Edge found;             ///< valid when `point` is not -1
  int point = -1;         ///< index among the contour's points; -1: no edge found
};

}  // namespace multireach::vision
