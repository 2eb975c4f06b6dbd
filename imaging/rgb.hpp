#pragma once

namespace multireach {

/// An RGB colour, 0 to 255 each.
struct Rgb {
  double r = 0, g = 0, b = 0;
};

}  // namespace multireach
