#pragma once

#include <span>
#include <vector>

#include "vision/contour/shading.hpp"

namespace multireach::vision {

/// The shading of most of an object's surface. Stripes, prints and highlights are left out of the fit, for they would
/// change the colour that is expected at every edge.
class SurfaceShading {
 public:
  void clear();
  /// Fits the shading to colours along the contour. With `plain`, all of them are of the same paint.
  void fit(std::span<const SurfaceColour> surface, bool plain);
  const Shading& shading() const { return shading_; }
  /// The largest distance of a colour from the fitted shading that noise (standard deviation of a pixel) and the
  /// model's errors explain, grey levels: a surface that is further away is of other paint.
  double most_apart(double noise) const;

 private:
  Shading shading_;
  double other_paint_ = 0;  // grey levels: a colour further from the shading belongs to other paint
  std::vector<double> apart_, sorted_;
  std::vector<SurfaceColour> same_paint_;
};

}  // namespace multireach::vision
