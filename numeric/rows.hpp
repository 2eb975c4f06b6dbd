#pragma once

namespace multireach {

/// Arms that are computed side by side: the doubles of the widest register that is used (AVX-512). Narrower ones take a
/// row in several parts.
inline constexpr int kRowLanes = 8;

/// One number of each of kRowLanes arms.
struct alignas(64) Row {
  double lane[kRowLanes];
  double& operator[](int arm) { return lane[arm]; }
  double operator[](int arm) const { return lane[arm]; }
};

}  // namespace multireach
