#pragma once

namespace multireach {

/// Number of arms, edges, colours ... computed together: the doubles of the widest SIMD register in use (AVX-512).
/// Narrower registers process a row in several parts.
inline constexpr int kRowLanes = 8;

/// One number for each lane.
struct alignas(64) Row {
  double lane[kRowLanes];
  double& operator[](int k) { return lane[k]; }
  double operator[](int k) const { return lane[k]; }
};

}  // namespace multireach
