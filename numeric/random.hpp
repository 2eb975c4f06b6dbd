#pragma once

#include <cstdint>

namespace multireach {

/// Counter-based random numbers, addressed by (seed, stream, counter): the same triple gives the same number on every
/// machine, independent of earlier draws. Mixes each word with the finaliser of SplitMix64 (Steele, Lea & Flood, OOPSLA
/// 2014).
class CounterRandom {
 public:
  explicit CounterRandom(uint64_t seed, uint64_t stream = 0) : key_(mix(mix(seed + kGolden) ^ (stream * kOdd))) {}

  uint64_t bits(uint64_t counter) const { return mix(key_ + counter * kGolden); }
  /// Uniform in [0, 1), with 53 random bits.
  double uniform(uint64_t counter) const { return static_cast<double>(bits(counter) >> 11) * 0x1.0p-53; }
  double uniform(uint64_t counter, double from, double to) const { return from + (to - from) * uniform(counter); }

 private:
  static constexpr uint64_t kGolden = 0x9e3779b97f4a7c15, kOdd = 0xd1342543de82ef95;
  static uint64_t mix(uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }
  uint64_t key_;
};

}  // namespace multireach
