#pragma once

#include <array>

#include "kinematics/joint_vector.hpp"

namespace multireach::controller {

/// A path in joint space: kSegments + 1 configurations (knots), rad or m. The first is where the path begins.
struct JointPath {
  static constexpr size_t kSegments = 24;
  std::array<std::array<double, kMaxJoints>, kSegments + 1> knots{};

  JointVector knot(size_t k, int joints) const { return Eigen::Map<const Eigen::VectorXd>(knots[k].data(), joints); }
  void set_knot(size_t k, const JointVector& theta) {
    for (int i = 0; i < theta.size(); ++i) knots[k][static_cast<size_t>(i)] = theta[i];
  }
  /// Puts the knots `first` to `last` on the straight line from `from` to `to`.
  void set_line(size_t first, size_t last, const JointVector& from, const JointVector& to) {
    for (size_t k = first; k <= last; ++k) {
      const double share = last > first ? static_cast<double>(k - first) / static_cast<double>(last - first) : 1;
      set_knot(k, from + share * (to - from));
    }
  }
};

}  // namespace multireach::controller
