// SIMD lanes of doubles, as many as the processor's registers hold, for files that Google Highway compiles once for
// each instruction set. Include after hwy/highway.h, in every pass; see Highway's documentation of foreach_target.h.
// The include guard toggles, because every pass needs this file again.
#if defined(MULTIREACH_NUMERIC_WIDE_LANES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef MULTIREACH_NUMERIC_WIDE_LANES_INL_HPP
#undef MULTIREACH_NUMERIC_WIDE_LANES_INL_HPP
#else
#define MULTIREACH_NUMERIC_WIDE_LANES_INL_HPP
#endif

#include <hwy/highway.h>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "numeric/lanes.hpp"
#include "numeric/rows.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using LanesTag = hn::CappedTag<double, kRowLanes>;
/// Number of lanes in a register; divides kRowLanes.
inline constexpr int kWidth = static_cast<int>(hn::MaxLanes(LanesTag()));

/// One boolean per lane.
struct LanesMask {
  hn::Mask<LanesTag> m;
  friend HWY_INLINE LanesMask operator&(LanesMask a, LanesMask b) { return {hn::And(a.m, b.m)}; }
  friend HWY_INLINE LanesMask operator|(LanesMask a, LanesMask b) { return {hn::Or(a.m, b.m)}; }
  friend HWY_INLINE LanesMask operator!(LanesMask a) { return {hn::Not(a.m)}; }
};

/// kWidth doubles. Every operation follows IEEE 754 per lane, so each lane is bit-identical to the computation with a
/// plain double.
struct Lanes {
  hn::Vec<LanesTag> v;

  Lanes() = default;
  HWY_INLINE Lanes(hn::Vec<LanesTag> value) : v(value) {}            // NOLINT: implicit, to wrap Highway's results
  HWY_INLINE Lanes(double value) : v(hn::Set(LanesTag(), value)) {}  // NOLINT: implicit, for constants in formulas

  friend HWY_INLINE Lanes operator+(Lanes a, Lanes b) { return hn::Add(a.v, b.v); }
  friend HWY_INLINE Lanes operator-(Lanes a, Lanes b) { return hn::Sub(a.v, b.v); }
  friend HWY_INLINE Lanes operator*(Lanes a, Lanes b) { return hn::Mul(a.v, b.v); }
  friend HWY_INLINE Lanes operator/(Lanes a, Lanes b) { return hn::Div(a.v, b.v); }
  friend HWY_INLINE Lanes operator-(Lanes a) { return hn::Neg(a.v); }
  friend HWY_INLINE Lanes& operator+=(Lanes& a, Lanes b) { return a = a + b; }
  friend HWY_INLINE Lanes& operator-=(Lanes& a, Lanes b) { return a = a - b; }
  friend HWY_INLINE Lanes& operator*=(Lanes& a, Lanes b) { return a = a * b; }
  friend HWY_INLINE LanesMask operator<(Lanes a, Lanes b) { return {hn::Lt(a.v, b.v)}; }
  friend HWY_INLINE LanesMask operator>(Lanes a, Lanes b) { return {hn::Gt(a.v, b.v)}; }
  friend HWY_INLINE LanesMask operator<=(Lanes a, Lanes b) { return {hn::Le(a.v, b.v)}; }
  friend HWY_INLINE LanesMask operator>=(Lanes a, Lanes b) { return {hn::Ge(a.v, b.v)}; }
  friend HWY_INLINE LanesMask operator==(Lanes a, Lanes b) { return {hn::Eq(a.v, b.v)}; }
};

HWY_INLINE Lanes where(LanesMask mask, Lanes yes, Lanes no) {
  return hn::IfThenElse(mask.m, yes.v, no.v);
}
HWY_INLINE Lanes square_root(Lanes a) {
  return hn::Sqrt(a.v);
}
HWY_INLINE Lanes rounded_down(Lanes a) {
  return hn::Floor(a.v);
}
HWY_INLINE Lanes absolute(Lanes a) {
  return hn::Abs(a.v);
}
HWY_INLINE Lanes with_sign_of(Lanes magnitude, Lanes sign) {
  return hn::CopySign(magnitude.v, sign.v);
}
/// lesser, greater and clamped behave as std::min, std::max and std::clamp.
HWY_INLINE Lanes lesser(Lanes a, Lanes b) {
  return hn::Min(b.v, a.v);
}
HWY_INLINE Lanes greater(Lanes a, Lanes b) {
  return hn::Max(b.v, a.v);
}
HWY_INLINE Lanes clamped(Lanes value, Lanes lower, Lanes upper) {
  return lesser(greater(value, lower), upper);
}
HWY_INLINE bool any(LanesMask mask) {
  return !hn::AllFalse(LanesTag(), mask.m);
}
HWY_INLINE LanesMask no_lane() {
  return {hn::MaskFromVec(hn::Zero(LanesTag()))};
}
/// One bit per lane; the first lane is the lowest bit.
HWY_INLINE uint32_t bits_of(LanesMask mask) {
#if HWY_TARGET == HWY_SCALAR
  return any(mask) ? 1 : 0;
#else
  uint8_t bytes[8] = {};
  hn::StoreMaskBits(LanesTag(), mask.m, bytes);
  return bytes[0];
#endif
}

HWY_INLINE Lanes load(const Row& row, int first) {
  return hn::Load(LanesTag(), row.lane + first);
}
HWY_INLINE void store(Lanes value, Row& row, int first) {
  hn::Store(value.v, LanesTag(), row.lane + first);
}

HWY_INLINE void quarter_turns(Lanes shifted, Lanes s, Lanes c, Lanes& sine, Lanes& cosine) {
  using Whole = hn::RebindToSigned<LanesTag>;
  const Whole whole;
  const auto quadrant = hn::BitCast(whole, shifted.v);
  const auto one = hn::Set(whole, 1), two = hn::Set(whole, 2);
  const auto swapped = hn::MaskFromVec(hn::BitCast(LanesTag(), hn::Neg(hn::And(quadrant, one))));
  const auto sine_sign = hn::ShiftLeft<62>(hn::And(quadrant, two));
  const auto cosine_sign = hn::ShiftLeft<62>(hn::And(hn::Add(quadrant, one), two));
  sine = hn::Xor(hn::IfThenElse(swapped, c.v, s.v), hn::BitCast(LanesTag(), sine_sign));
  cosine = hn::Xor(hn::IfThenElse(swapped, s.v, c.v), hn::BitCast(LanesTag(), cosine_sign));
}

inline HWY_NOINLINE void wrap_large_angles(Row& angles) {
  for (int lane = 0; lane < kWidth; ++lane) {
    if (std::abs(angles[lane]) > kMaxAngle) angles[lane] = std::remainder(angles[lane], 2 * std::numbers::pi);
  }
}
/// Reduces angles beyond kMaxAngle by whole turns.
HWY_INLINE Lanes wrapped_angle(Lanes angle) {
  if (HWY_LIKELY(!any(absolute(angle) > kMaxAngle))) return angle;
  Row row;
  store(angle, row, 0);
  wrap_large_angles(row);
  return load(row, 0);
}

#include "numeric/sine_cosine.inl.hpp"

#include "numeric/arc_tangent.inl.hpp"

}  // namespace HWY_NAMESPACE
}  // namespace multireach
HWY_AFTER_NAMESPACE();

#endif
