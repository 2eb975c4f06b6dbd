// Include inside a namespace that defines Lanes and `quarter_turns` for them: lanes.hpp includes this file for double
// and Double2, wide_lanes-inl.hpp for each instruction set. All use this one source, so all give the same bits.

/// Sine and cosine of each lane, with an absolute error of at most 1e-15 for |angle| <= kMaxAngle. Beyond, the
/// output has no meaning. Argument reduction after Cody & Waite (Software Manual for the Elementary Functions, 1980)
/// with pi/2 in three parts; then the Taylor series on [-pi/4, pi/4], where the first omitted term is below 5e-17.
template <class Lanes>
inline void sine_and_cosine(Lanes angle, Lanes& sine, Lanes& cosine) {
  // Adding and subtracting 1.5 * 2^52 rounds to the nearest integer, which is then in the low bits of the sum.
  constexpr double kRound = 0x1.8p52, kTwoOverPi = 0x1.45f306dc9c883p-1;
  constexpr double kHigh = 0x1.921fb544p0, kMiddle = 0x1.0b4611a6p-34, kLow = 0x1.3198a2e037073p-69;
  const Lanes shifted = angle * kTwoOverPi + kRound;
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
  quarter_turns(shifted, s, c, sine, cosine);
}
