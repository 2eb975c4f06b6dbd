#pragma once

#include <bit>
#include <cstdint>

namespace multireach {

/// Two doubles side by side in one register (SSE2, NEON): the kinematics of two postures cost hardly more than of one.
/// Every operation is done per lane as IEEE 754 says, so a lane has the bits that a plain double would have.
using Pair = double __attribute__((vector_size(16)));
using PairBits = int64_t __attribute__((vector_size(16)));

/// The integers of the same width, for masks and signs.
template <class Lanes>
struct BitsOf;
template <>
struct BitsOf<double> {
  using Type = int64_t;
};
template <>
struct BitsOf<Pair> {
  using Type = PairBits;
};

/// Sine and cosine of each lane, to 1e-15 absolutely for |angle| <= kLargestAngle. Beyond, the output has no
/// meaning. Argument reduction after Cody & Waite (Software Manual for the Elementary Functions, 1980)
/// with pi/2 in three parts; then Taylor's series on [-pi/4, pi/4], whose first term left out is below 5e-17 there.
inline constexpr double kLargestAngle = 1e5;

template <class Lanes>
inline void sine_and_cosine(Lanes angle, Lanes& sine, Lanes& cosine) {
  using Bits = typename BitsOf<Lanes>::Type;
  // Adding and taking away 1.5 * 2^52 rounds to the nearest integer, which is then in the low bits of the sum.
  constexpr double kRound = 0x1.8p52, kTwoOverPi = 0x1.45f306dc9c883p-1;
  constexpr double kHigh = 0x1.921fb544p0, kMiddle = 0x1.0b4611a6p-34, kLow = 0x1.3198a2e037073p-69;
  const Lanes shifted = angle * kTwoOverPi + kRound;
  const Bits quadrant = std::bit_cast<Bits>(shifted);
  const Lanes turns = shifted - kRound;
  const Lanes r = ((angle - turns * kHigh) - turns * kMiddle) - turns * kLow;
  const Lanes r2 = r * r, r4 = r2 * r2, r8 = r4 * r4;
  const Lanes odd =
      ((r2 * (-1.0 / 39916800) + 1.0 / 362880) + r4 * (r2 * (-1.0 / 1307674368000) + 1.0 / 6227020800)) * r4 +
      (r2 * (-1.0 / 5040) + 1.0 / 120);
  const Lanes s = r + r * r2 * (odd * r2 + (-1.0 / 6));
  const Lanes even = ((r2 * (-1.0 / 720) + 1.0 / 24) + r4 * (r2 * (-1.0 / 3628800) + 1.0 / 40320)) +
                     r8 * ((r2 * (-1.0 / 87178291200) + 1.0 / 479001600) + r4 * (1.0 / 20922789888000));
  const Lanes c = (1 - r2 * 0.5) + r4 * even;
  const Bits swapped = -(quadrant & 1), kept = ~swapped;
  const Bits sine_sign = (quadrant & 2) << 62, cosine_sign = ((quadrant + 1) & 2) << 62;
  const Bits s_bits = std::bit_cast<Bits>(s), c_bits = std::bit_cast<Bits>(c);
  sine = std::bit_cast<Lanes>(((s_bits & kept) | (c_bits & swapped)) ^ sine_sign);
  cosine = std::bit_cast<Lanes>(((c_bits & kept) | (s_bits & swapped)) ^ cosine_sign);
}

}  // namespace multireach
