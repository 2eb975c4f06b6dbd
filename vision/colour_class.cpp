#include "vision/colour_class.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace multireach::vision {
namespace {

double luma(const Rgb& colour) {
  return 0.25 * (colour.r + 2 * colour.g + colour.b);
}

double chroma_distance(const Rgb& a, const Rgb& b) {
  const double ya = luma(a), yb = luma(b);
  const double red = (a.r - a.g) / ya - (b.r - b.g) / yb, blue = (a.b - a.g) / ya - (b.b - b.g) / yb;
  return std::sqrt(red * red + blue * blue);
}

/// A row of BGR pixels to a row of the mask: the upper five bits of each byte, side by side, are a place in the table.
void classify_row_anywhere(const uint8_t* table, const uint8_t* in, uint8_t* out, int pixels) {
  for (int i = 0; i < pixels; ++i, in += 3) out[i] = table[(in[2] >> 3) << 10 | (in[1] >> 3) << 5 | in[0] >> 3];
}

#if defined(__x86_64__)
/// The same with one instruction for the place; reads four bytes for each pixel but the last.
[[gnu::target("bmi2")]] void classify_row_bmi2(const uint8_t* table, const uint8_t* in, uint8_t* out, int pixels) {
  for (int i = 0; i + 1 < pixels; ++i) {
    uint32_t pixel;
    std::memcpy(&pixel, in + 3 * i, 4);
    out[i] = table[_pext_u32(pixel, 0xf8f8f8)];
  }
  classify_row_anywhere(table, in + 3 * (pixels - 1), out + pixels - 1, 1);
}
#endif

void classify_row(const uint8_t* table, const uint8_t* in, uint8_t* out, int pixels) {
#if defined(__x86_64__)
  static const bool kBmi2 = __builtin_cpu_supports("bmi2");
  if (kBmi2) return classify_row_bmi2(table, in, out, pixels);
#endif
  classify_row_anywhere(table, in, out, pixels);
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
        table_[r << 10 | g << 5 | b] = member ? 255 : 0;
      }
    }
  }
}

void ColourTable::classify(const cv::Mat& bgr, cv::Mat& mask) const {
  mask.create(bgr.size(), CV_8UC1);
  for (int row = 0; row < bgr.rows; ++row) {
    classify_row(table_.data(), bgr.ptr<uint8_t>(row), mask.ptr<uint8_t>(row), bgr.cols);
  }
}

}  // namespace multireach::vision
