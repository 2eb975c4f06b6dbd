// Edges of a contour in SIMD lanes, for files that Google Highway compiles once for each instruction set. Include after
// hwy/highway.h, in every pass; see Highway's documentation of foreach_target.h. The include guard toggles, because
// every pass needs this file again.
#if defined(MULTIREACH_VISION_EDGE_LANES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef MULTIREACH_VISION_EDGE_LANES_INL_HPP
#undef MULTIREACH_VISION_EDGE_LANES_INL_HPP
#else
#define MULTIREACH_VISION_EDGE_LANES_INL_HPP
#endif

#include <hwy/highway.h>

#include <array>

#include "numeric/wide_lanes-inl.hpp"
#include "vision/contour/edge_block.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach::vision {
namespace HWY_NAMESPACE {

using multireach::HWY_NAMESPACE::kWidth;
using multireach::HWY_NAMESPACE::Lanes;
using multireach::HWY_NAMESPACE::LanesMask;
using multireach::HWY_NAMESPACE::load;
using multireach::HWY_NAMESPACE::no_lane;
using multireach::HWY_NAMESPACE::store;

constexpr int kSide = EdgeModel::kSide;

struct Colour {
  Lanes b, g, r;
  friend HWY_INLINE Colour operator+(const Colour& a, const Colour& c) { return {a.b + c.b, a.g + c.g, a.r + c.r}; }
  friend HWY_INLINE Colour operator-(const Colour& a, const Colour& c) { return {a.b - c.b, a.g - c.g, a.r - c.r}; }
  friend HWY_INLINE Colour operator*(Lanes a, const Colour& c) { return {a * c.b, a * c.g, a * c.r}; }
};
HWY_INLINE Lanes dot(const Colour& a, const Colour& c) {
  return a.b * c.b + a.g * c.g + a.r * c.r;
}

/// The pixels `outwards` of the middle ones of the edgels `first` to first + kWidth - 1 of a block.
HWY_INLINE Colour pixel_of(const EdgeBlock& block, int outwards, int first) {
  const auto& [b, g, r] = block.bgr[static_cast<size_t>(EdgeProfile::kReach + outwards)];
  return {load(b, first), load(g, first), load(r, first)};
}

using Terms = std::array<Lanes, Shading::kTerms>;

/// Shading::Terms of a unit normal.
HWY_INLINE Terms terms_of(const std::array<Lanes, 3>& n) {
  const auto& [x, y, z] = n;
  return {1.0, x, y, z, x * y, x * z, y * z, x * x - y * y, 3.0 * z * z - 1.0};
}

/// Shading::colour(). The sums of this file and of discriminant() have the order that Eigen gives them on two lanes:
/// another one changes the last bits of every position.
HWY_INLINE Colour colour_of(const Shading& shading, const Terms& t) {
  const auto channel = [&](int k) -> Lanes {
    const double* c = shading.coefficients(k);
    return t[0] * c[0] + t[2] * c[2] + (t[4] * c[4] + t[6] * c[6]) +
           (t[1] * c[1] + t[3] * c[3] + (t[5] * c[5] + t[7] * c[7])) + t[8] * c[8];
  };
  return {channel(0), channel(1), channel(2)};
}

/// The edgels `first` to first + kWidth - 1 of a block.
struct EdgeLanes {
  Lanes at, middle, outward, cosine, normal_x, normal_y;
  LanesMask along_row;

  EdgeLanes(const EdgeBlock& block, int first)
      : at(load(block.at, first)),
        middle(load(block.middle, first)),
        outward(load(block.outward, first)),
        cosine(load(block.cosine, first)),
        normal_x(load(block.normal_x, first)),
        normal_y(load(block.normal_y, first)),
        along_row(load(block.along_row, first) > 0.5) {}

  /// The expected position, pixels outwards of the profile's middle.
  HWY_INLINE Lanes expected() const { return (at - middle) * outward; }

  /// Surface normals of the sphere, in the camera's axes, `outwards` pixels from the middle of each profile: at the
  /// centre of the part of the pixel that is inside the contour.
  HWY_INLINE std::array<Lanes, 3> surface_normal(double radius_px, Lanes outwards) const {
    const Lanes edge = expected(), begin = outwards - 0.5, end = clamped(edge, begin, outwards + 0.5);
    const Lanes position = lesser(edge, 0.5 * (begin + end)), move = outward * (position - edge) / radius_px;
    Lanes x = where(along_row, normal_x + move, normal_x), y = where(along_row, normal_y, normal_y + move);
    const Lanes r2 = x * x + y * y, r = square_root(r2);
    const LanesMask beyond = r2 > 1.0;
    return {where(beyond, x / r, x), where(beyond, y / r, y), square_root(greater(0.0, 1.0 - r2))};
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace multireach::vision
HWY_AFTER_NAMESPACE();

#endif
