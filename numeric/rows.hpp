#pragma once

namespace multireach {

/// Number of arms computed together: the doubles of the widest SIMD register in use (AVX-512). Narrower registers
/// process a row in several parts.
inline constexpr int kRowLanes = 8;

/// One number for each of kRowLanes arms.
struct alignas(64) Row {
  double lane[kRowLanes];
  double& operator[](int arm) { return lane[arm]; }
  double operator[](int arm) const { return lane[arm]; }
};

}  // namespace multireach
