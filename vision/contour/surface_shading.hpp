#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "vision/contour/contour_edgel.hpp"
#include "vision/contour/edge_profile.hpp"

namespace multireach::vision {

/// The colour of the object's surface where its normal is known: BGR, grey levels.
struct SurfaceColour {
  Eigen::Vector3d normal, bgr;
};

/// The shading of most of an object's surface. Stripes, prints and highlights are left out of the fit, for they would
/// change the colour that is expected at every edge.
class SurfaceShading {
 public:
  void clear();
  /// Fits the shading to colours along the contour. With `plain`, all of them are of the same paint.
  void fit(std::span<const SurfaceColour> surface, bool plain);
  const Shading& shading() const { return shading_; }
  /// Whether the object's surface beside an edge has a colour that the shading does not explain; false before `fit`.
  /// `noise`: standard deviation of a pixel, grey levels; `radius_px`: of the contour.
  bool painted(const EdgeProfile& profile, const ContourEdgel& edgel, double radius_px, double noise) const;

 private:
  Shading shading_;
  double other_paint_ = 0;  // grey levels: a colour further from the shading belongs to other paint
  std::vector<double> apart_, sorted_;
};

}  // namespace multireach::vision
