#pragma once

#include <vector>

#include "imaging/rgb.hpp"

namespace multireach::vision {

/// Colours of an object, given by reference colours. A colour belongs to the object when its chroma ratios U = (R -
/// G)/Y and V = (B - G)/Y, with Y = (R + 2G + B)/4, lie within `tolerance` of a reference colour, and Y is between
/// `min_luma` and `max_luma`. The ratios do not change with exposure.
struct ColourClass {
  std::vector<Rgb> references;
  double tolerance = 0.3;
  double min_luma = 12, max_luma = 250;
};

}  // namespace multireach::vision
