#pragma once

#include "kinematics/chain.hpp"
#include "numeric/trigonometry.hpp"

namespace multireach {

/// Forward kinematics from W to T, joint by joint. Calls `visit(i, axis_W, p_WJ, X_WL)` with the axis of joint i, a
/// point on it, and the pose of the link that it moves, in the frame of the joint. Returns X_WT.
///
/// This is the formula for everything but the control law's inner loop. That has FastChain, which splits the fixed
/// rotations and merges part of them with the joint angles: less work, but other rounding. Tests compare both.
template <class Theta, class Visit>
Eigen::Isometry3d visit_joints(const Chain& chain, const Theta& theta, Visit&& visit) {
  Eigen::Isometry3d X = chain.fixed(0);
  for (int i = 0; i < chain.size(); ++i) {
    const Joint& joint = chain.joint(i);
    const Eigen::Vector3d axis_W = X.linear() * joint.axis, p_WJ = X.translation();
    if (joint.type == Joint::Type::kPrismatic) {
      X.translation() += axis_W * theta[i];
    } else {
      X.linear() = X.linear() * rotation_about(joint.axis, theta[i]);
    }
    visit(i, axis_W, p_WJ, X);
    X = X * chain.fixed(i + 1);
  }
  return X;
}

}  // namespace multireach
