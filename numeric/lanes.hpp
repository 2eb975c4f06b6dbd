#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace multireach {

/// Two doubles in one SIMD register (SSE2, NEON): kinematics of two joint configurations cost hardly more than of one.
/// Every operation follows IEEE 754 per lane, so each lane is bit-identical to the computation with a plain double.
using Double2 = double __attribute__((vector_size(16)));
using Double2Bits = int64_t __attribute__((vector_size(16)));

/// The integer type of the same width, for masks and signs.
template <class Lanes>
struct BitsOf;
template <>
struct BitsOf<double> {
  using Type = int64_t;
};
template <>
struct BitsOf<Double2> {
  using Type = Double2Bits;
};

/// Largest magnitude of an angle for `sine_and_cosine`, rad.
inline constexpr double kMaxAngle = 1e5;

/// Sine and cosine of an angle, from s and c of the remainder after whole quarter turns; the low bits of `shifted` hold
/// the number of quarter turns.
template <class Lanes>
inline void quarter_turns(Lanes shifted, Lanes s, Lanes c, Lanes& sine, Lanes& cosine) {
  using Bits = typename BitsOf<Lanes>::Type;
  const Bits quadrant = std::bit_cast<Bits>(shifted);
  const Bits swapped = -(quadrant & 1), kept = ~swapped;
  const Bits sine_sign = (quadrant & 2) << 62, cosine_sign = ((quadrant + 1) & 2) << 62;
  const Bits s_bits = std::bit_cast<Bits>(s), c_bits = std::bit_cast<Bits>(c);
  sine = std::bit_cast<Lanes>(((s_bits & kept) | (c_bits & swapped)) ^ sine_sign);
  cosine = std::bit_cast<Lanes>(((c_bits & kept) | (s_bits & swapped)) ^ cosine_sign);
}

// The functions of lanes for a plain double, so that one template serves both.
inline double where(bool condition, double yes, double no) {
  return condition ? yes : no;
}
inline bool any(bool condition) {
  return condition;
}
inline double square_root(double a) {
  return std::sqrt(a);
}
inline double rounded_down(double a) {
  return std::floor(a);
}
inline double absolute(double a) {
  return std::abs(a);
}
inline double lesser(double a, double b) {
  return std::min(a, b);
}
inline double greater(double a, double b) {
  return std::max(a, b);
}
inline double with_sign_of(double magnitude, double sign) {
  return std::copysign(magnitude, sign);
}
inline double clamped(double value, double lower, double upper) {
  return lesser(greater(value, lower), upper);
}

#include "numeric/sine_cosine.inl.hpp"

#include "numeric/arc_tangent.inl.hpp"

}  // namespace multireach
