#pragma once

#include <vector>

#include "imaging/rgb.hpp"

namespace multireach::vision {

/// Which colours belong to the object: those whose chroma ratios U = (R - G)/Y and V = (B - G)/Y, with Y = (R + 2G +
/// B)/4, lie within `tolerance` of one of the reference colours, and that are neither darker than `darkest` nor
/// brighter than `brightest` in Y. The ratios do not change with exposure.
struct ColourClass {
  std::vector<Rgb> references;
  double tolerance = 0.3;
  double darkest = 12, brightest = 250;
};

}  // namespace multireach::vision
