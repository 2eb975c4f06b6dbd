#pragma once

namespace multireach {

/// Where a simulated joint with these limits starts unless told otherwise: at 0, or in the middle of limits that
/// exclude 0. Rad or m; the limits may be infinite.
inline double default_joint_position(double lower, double upper) {
  return lower <= 0 && 0 <= upper ? 0 : 0.5 * (lower + upper);
}

}  // namespace multireach
