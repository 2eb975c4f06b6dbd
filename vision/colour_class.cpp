#include "vision/colour_class.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::vision {
namespace {

double luma(const Rgb& colour) {
  return 0.25 * (colour.r + 2 * colour.g + colour.b);
}

double chroma_distance(const Rgb& a, const Rgb& b) {
  const double ya = luma(a), yb = luma(b);
  return std::hypot((a.r - a.g) / ya - (b.r - b.g) / yb, (a.b - a.g) / ya - (b.b - b.g) / yb);
}

}  // namespace

ColourTable::ColourTable(const ColourClass& colours) {
  for (int b = 0; b < 32; ++b) {
    for (int g = 0; g < 32; ++g) {
      for (int r = 0; r < 32; ++r) {
        const Rgb middle{8.0 * r + 3.5, 8.0 * g + 3.5, 8.0 * b + 3.5};
        const bool lit = luma(middle) >= colours.darkest && luma(middle) <= colours.brightest;
        const bool member = lit && std::ranges::any_of(colours.references, [&](const Rgb& reference) {
                              return chroma_distance(middle, reference) <= colours.tolerance;
                            });
        table_[b << 10 | g << 5 | r] = member ? 255 : 0;
      }
    }
  }
}

void ColourTable::classify(const cv::Mat& bgr, cv::Mat& mask) const {
  mask.create(bgr.size(), CV_8UC1);
  for (int row = 0; row < bgr.rows; ++row) {
    const uint8_t* in = bgr.ptr<uint8_t>(row);
    uint8_t* out = mask.ptr<uint8_t>(row);
    for (int column = 0; column < bgr.cols; ++column, in += 3) {
      out[column] = table_[(in[0] >> 3) << 10 | (in[1] >> 3) << 5 | in[2] >> 3];
    }
  }
}

}  // namespace multireach::vision
