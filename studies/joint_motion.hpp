#pragma once

#include <algorithm>
#include <vector>

#include "kinematics/joint_vector.hpp"

namespace multireach {

inline constexpr double kMotionSampling = 0.001;  ///< s

/// A robot's joint positions, rad (m), at times in steps of kMotionSampling from 0.
using JointMotion = std::vector<JointVector>;

/// The state of a robot's joints at one time.
struct Knot {
  double time = 0;              ///< s
  JointVector theta, velocity;  ///< rad, rad/s (m, m/s)
};

/// Samples the motion through `knots` (at least two), from time 0 to `end`, s: cubic Hermite polynomials.
inline JointMotion sampled_motion(const std::vector<Knot>& knots, double end) {
  JointMotion motion;
  size_t k = 0;
  for (double t = 0; t < end; t += kMotionSampling) {
    while (k + 2 < knots.size() && knots[k + 1].time <= t) ++k;
    const Knot &a = knots[k], &b = knots[k + 1];
    const double seconds = b.time - a.time, s = std::clamp((t - a.time) / seconds, 0.0, 1.0), s2 = s * s, s3 = s2 * s;
    motion.push_back((2 * s3 - 3 * s2 + 1) * a.theta + (s3 - 2 * s2 + s) * seconds * a.velocity +
                     (3 * s2 - 2 * s3) * b.theta + (s3 - s2) * seconds * b.velocity);
  }
  return motion;
}

}  // namespace multireach
