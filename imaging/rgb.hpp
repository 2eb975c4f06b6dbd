#pragma once

namespace multireach {

/// An RGB colour, each channel from 0 to 255.
struct Rgb {
  double r = 0, g = 0, b = 0;
};

}  // namespace multireach
