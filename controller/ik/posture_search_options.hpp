#pragma once

#include <cstdint>

namespace multireach::controller {

/// How hard a posture that reaches a target is looked for.
struct PostureSearchOptions {
  int samples = 61;           ///< angles of the third joint tried per curve, where there is a closed form
  int starts = 32;            ///< random postures to start from, where there is none
  int solutions = 6;          ///< of these starts, no more are tried once so many have reached the target
  int most_starts = 200;      ///< random postures to start from while none has reached the target
  uint64_t seed = 1;          ///< of those postures; the same seed finds the same posture
  double tolerance_m = 1e-7;  ///< a posture reaches a target when its hand is this near
};

}  // namespace multireach::controller
