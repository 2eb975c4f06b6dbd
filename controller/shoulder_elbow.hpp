#pragma once

#include <array>
#include <optional>

#include "kinematics/chain.hpp"

namespace multireach::controller {

/// Closed-form inverse kinematics of an arm of four turning joints whose first three axes meet in one point, the
/// shoulder; the fourth is the elbow. The Hoap2's arm is one. The postures that reach a point form up to four curves,
/// each with the third joint as its parameter: the elbow from the distance to the shoulder, then the first two joints
/// by Paden and Kahan's second subproblem (Murray, Li & Sastry, A Mathematical Introduction to Robotic Manipulation,
/// 1994, Sect. 3.2).
class ShoulderElbow {
 public:
  /// Nothing when the chain is not of this kind.
  static std::optional<ShoulderElbow> from(const Chain& chain);

  /// The posture nearest to `theta` (Euclidean norm) among those inside the limits whose tip is at `x_T` (m, in W), or
  /// nothing when there is none. The third joint is sampled at `samples` angles, then refined on the best curve.
  std::optional<JointVector> nearest(const Chain& chain, const Eigen::Vector3d& x_T, const JointVector& theta,
                                     int samples) const;

 private:
  ShoulderElbow() = default;
  std::optional<JointVector> posture(const Chain& chain, const Eigen::Vector3d& v, const JointVector& theta,
                                     double third, double fourth, int branch) const;

  Eigen::Vector3d shoulder_;             // in W
  std::array<Eigen::Vector3d, 4> axis_;  // at the zero posture, in W
  Eigen::Vector3d elbow_;                // a point on the fourth axis, relative to the shoulder
  Eigen::Vector3d forearm_;              // from that point to the tip, at the zero posture
};

}  // namespace multireach::controller
