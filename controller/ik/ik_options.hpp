#pragma once

#include <cstdint>

#include "kinematics/joint_vector.hpp"

namespace multireach::controller {

/// Effort and tolerance of the inverse kinematics.
struct IkOptions {
  int samples = 61;       ///< closed form: sampled angles of the third joint per curve
  int starts = 32;        ///< without closed form: random start configurations of the iterative solver
  int solutions = 6;      ///< stop trying starts after this many solutions
  int most_starts = 200;  ///< largest number of starts while there is no solution
  uint64_t seed = 1;      ///< of the random starts; the same seed gives the same solution
  /// Weight of each joint in distances between configurations, and in what moves; infinite locks a joint. Empty: all
  /// weigh the same.
  JointVector joint_weights{};
  double tolerance_m = 1e-7;  ///< a configuration is a solution when its task error is at most this
};

}  // namespace multireach::controller
