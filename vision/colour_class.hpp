#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace multireach::vision {

/// An RGB colour, 0 to 255 each.
struct Rgb {
  double r = 0, g = 0, b = 0;
};

/// Which colours belong to the object: those whose chroma ratios U = (R - G)/Y and V = (B - G)/Y, with Y = (R + 2G +
/// B)/4, lie within `tolerance` of one of the reference colours, and that are neither darker than `darkest` nor
/// brighter than `brightest` in Y. The ratios do not change with exposure.
struct ColourClass {
  std::vector<Rgb> references;
  double tolerance = 0.3;
  double darkest = 12, brightest = 250;
};

/// A colour class as a table over the upper five bits of each channel, 32 KiB.
class ColourTable {
 public:
  explicit ColourTable(const ColourClass& colours);

  bool contains(uint8_t b, uint8_t g, uint8_t r) const { return table_[(r >> 3) << 10 | (g >> 3) << 5 | b >> 3] != 0; }
  /// 8-bit mask of a BGR image: 255 where the pixel belongs to the class, else 0. `mask` is made to fit.
  void classify(const cv::Mat& bgr, cv::Mat& mask) const;

 private:
  std::array<uint8_t, 32 * 32 * 32> table_;
};

}  // namespace multireach::vision
