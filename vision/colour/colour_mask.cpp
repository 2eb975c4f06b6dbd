#include "vision/colour/colour_mask.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/colour/colour_mask.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace multireach::vision {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET != HWY_SCALAR
using Bytes = hn::CappedTag<uint8_t, 64>;

/// Tests 64 pixels against the boxes; one bit per pixel.
class Candidates {
 public:
  explicit HWY_INLINE Candidates(const ColourBoxes& boxes)
      : red_(hn::LoadDup128(Bytes(), boxes.red.data())),
        green_(hn::LoadDup128(Bytes(), boxes.green.data())),
        blue_(hn::LoadDup128(Bytes(), boxes.blue.data())) {}

  HWY_INLINE uint64_t operator()(const uint8_t* bgr) const {
    constexpr size_t kLanes = hn::MaxLanes(Bytes());
    alignas(8) uint8_t bits[64 / 8];
    for (size_t first = 0; first < 64; first += kLanes) {
      hn::Vec<Bytes> b, g, r;
      hn::LoadInterleaved3(Bytes(), bgr + 3 * first, b, g, r);
      const auto inside = hn::And(hn::TableLookupBytes(blue_, hn::ShiftRight<4>(b)),
                                  hn::And(hn::TableLookupBytes(green_, hn::ShiftRight<4>(g)),
                                          hn::TableLookupBytes(red_, hn::ShiftRight<4>(r))));
      hn::StoreMaskBits(Bytes(), hn::Ne(inside, hn::Zero(Bytes())), bits + first / 8);
    }
    uint64_t word = 0;
    if constexpr (std::endian::native == std::endian::little) {
      std::memcpy(&word, bits, sizeof(word));
    } else {
      for (size_t i = 0; i < 8; ++i) word |= static_cast<uint64_t>(bits[i]) << (8 * i);
    }
    return word;
  }

 private:
  hn::Vec<Bytes> red_, green_, blue_;
};
#else
struct Candidates {
  explicit Candidates(const ColourBoxes&) {}
  uint64_t operator()(const uint8_t*) const { return ~uint64_t{0}; }
};
#endif

/// Tests the candidate pixels against the colour table; one bit per pixel.
HWY_INLINE uint64_t members(const ColourTable& colours, const uint8_t* bgr, uint64_t candidates, int& count) {
  uint64_t word = 0;
  for (; candidates != 0; candidates &= candidates - 1) {
    const int i = std::countr_zero(candidates);
    const uint8_t* pixel = bgr + 3 * i;
    const bool is_member = colours.contains(pixel[0], pixel[1], pixel[2]);
    word |= static_cast<uint64_t>(is_member) << i;
    count += is_member ? 1 : 0;
  }
  return word;
}

int colour_mask_of(const ColourTable& colours, const uint8_t* bgr, int pixels, uint64_t* words) {
  const Candidates candidates(colours.boxes());
  const int whole = pixels / 64, rest = pixels % 64;
  int count = 0;
  for (int k = 0; k < whole; ++k, bgr += 192) {
    const uint64_t some = candidates(bgr);
    words[k] = some == 0 ? 0 : members(colours, bgr, some, count);
  }
  if (rest == 0) return count;
  uint8_t last[192] = {};
  std::memcpy(last, bgr, 3 * static_cast<size_t>(rest));
  words[whole] = members(colours, last, candidates(last) & ((uint64_t{1} << rest) - 1), count);
  return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach::vision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace multireach::vision {

HWY_EXPORT(colour_mask_of);

int colour_mask_row(const ColourTable& colours, const uint8_t* bgr, int pixels, uint64_t* words) {
  return HWY_DYNAMIC_DISPATCH(colour_mask_of)(colours, bgr, pixels, words);
}

}  // namespace multireach::vision
#endif
