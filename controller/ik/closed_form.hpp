#pragma once

#include <array>
#include <optional>
#include <vector>

#include "kinematics/chain.hpp"

namespace multireach::controller {

/// The geometry of an arm with four revolute joints whose first three axes meet in one point, the shoulder; the fourth
/// joint is the elbow. Units m and rad; directions are in W at the zero configuration.
struct ClosedFormArm {
  std::array<double, 3> shoulder;             // in W
  std::array<std::array<double, 3>, 4> axis;  // joint axes, unit vectors
  std::array<double, 3> elbow;                // a point on the fourth axis, relative to the shoulder
  std::array<double, 3> forearm;              // from that point to the tip
  std::array<double, 4> lower, upper;         // joint limits
  // |elbow + Rot(axis 3, angle) forearm|^2 = elbow2 + forearm2 + 2 (radius cos(angle - middle) + along).
  double elbow2, forearm2, radius, middle, along;
  double cosine12, inverse_sine12_2;  // cosine, and 1 / sine^2, of the angle between the first two axes
  std::array<double, 3> across12;     // cross product of the first two axes
  int samples;                        // number of samples of the third angle, from third_from to third_to
  double third_from, third_to, third_step;
  std::vector<std::array<std::array<double, 3>, 3>> turned;  // rotation matrices (rows) of these samples

  double third(int sample) const { return sample + 1 < samples ? third_from + sample * third_step : third_to; }
};

/// Closed-form inverse kinematics of a shoulder-elbow arm (ClosedFormArm), e.g. the Hoap2's. The IK solutions of a
/// point form up to four curves, with the third joint as the parameter. The elbow angle follows from the target's
/// distance to the shoulder; the first two joints follow from Paden and Kahan's second subproblem (Murray, Li & Sastry,
/// A Mathematical Introduction to Robotic Manipulation, 1994, Sect. 3.2).
class ClosedFormIk {
 public:
  /// Samples the third joint at `samples` angles (at least 2). nullopt when the chain has another geometry.
  static std::optional<ClosedFormIk> from(const Chain& chain, int samples);

  /// The IK solution for `x_T` (m, in W) inside the joint limits that is nearest to `theta` (Euclidean norm): the best
  /// sample, refined along its curve. nullopt when no sample gives a solution.
  [[nodiscard]] std::optional<JointVector> nearest(const Eigen::Vector3d& x_T, const JointVector& theta) const;
  const ClosedFormArm& arm() const { return arm_; }

 private:
  explicit ClosedFormIk(ClosedFormArm arm) : arm_(std::move(arm)) {}
  ClosedFormArm arm_;
};

}  // namespace multireach::controller
