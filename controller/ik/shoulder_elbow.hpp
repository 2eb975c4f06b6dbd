#pragma once

#include <array>
#include <optional>
#include <vector>

#include "kinematics/chain.hpp"

namespace multireach::controller {

/// An arm of four turning joints whose first three axes meet in one point, the shoulder; the fourth is the elbow. What
/// the closed form needs of it, in plain numbers: m and rad, directions in W at the zero posture.
struct ShoulderElbowArm {
  std::array<double, 3> shoulder;             // in W
  std::array<std::array<double, 3>, 4> axis;  // unit vectors
  std::array<double, 3> elbow;                // a point on the fourth axis, relative to the shoulder
  std::array<double, 3> forearm;              // from that point to the tip
  std::array<double, 4> lower, upper;         // limits
  // |elbow + Rot(axis 3, angle) forearm|^2 = elbow2 + forearm2 + 2 (radius cos(angle - middle) + along).
  double elbow2, forearm2, radius, middle, along;
  double cosine12, inverse_sine12_2;  // of the angle between the first two axes; 1 over the square
  std::array<double, 3> across12;     // their cross product
  int samples;                        // of the third angle, from third_from to third_to
  double third_from, third_to, third_step;
  std::vector<std::array<std::array<double, 3>, 3>> turned;  // rotations (rows) about the third axis by these angles

  double third(int sample) const { return sample + 1 < samples ? third_from + sample * third_step : third_to; }
};

/// Closed-form inverse kinematics of such an arm. The Hoap2's is one. The postures that reach a point form up to four
/// curves, each with the third joint as its parameter: the elbow from the distance to the shoulder, then the first two
/// joints by Paden and Kahan's second subproblem (Murray, Li & Sastry, A Mathematical Introduction to Robotic
/// Manipulation, 1994, Sect. 3.2).
class ShoulderElbow {
 public:
  /// Nothing when the chain is not of this kind. The third joint is sampled at `samples` angles (at least 2).
  static std::optional<ShoulderElbow> from(const Chain& chain, int samples);

  /// The posture nearest to `theta` (Euclidean norm) among those inside the limits whose tip is at `x_T` (m, in W), or
  /// nothing when there is none: of the samples, then refined on the best curve.
  std::optional<JointVector> nearest(const Eigen::Vector3d& x_T, const JointVector& theta) const;
  const ShoulderElbowArm& arm() const { return arm_; }

 private:
  explicit ShoulderElbow(ShoulderElbowArm arm) : arm_(std::move(arm)) {}
  ShoulderElbowArm arm_;
};

}  // namespace multireach::controller
