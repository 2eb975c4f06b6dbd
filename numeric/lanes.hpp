#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace multireach {

/// Two doubles side by side in one register (SSE2, NEON): the kinematics of two postures cost hardly more than of one.
/// Every operation is done per lane as IEEE 754 says, so a lane has the bits that a plain double would have.
using Double2 = double __attribute__((vector_size(16)));
using Double2Bits = int64_t __attribute__((vector_size(16)));

/// The integers of the same width, for masks and signs.
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

/// The largest angle of `sine_and_cosine`, rad.
inline constexpr double kLargestAngle = 1e5;

/// Sine and cosine of an angle from s and c, those of what is left of it after whole quarter turns, whose number is in
/// the low bits of `shifted`.
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

// What formulas of several lanes need, for one.
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
