#pragma once

#include "kinematics/chain.hpp"

namespace multireach::controller {

/// Weights of the joints, at least 1: where several motions serve the hand, a joint moves 1 / weight^2 times as much as
/// one of weight 1. An infinite weight locks a joint: it never moves. By default all weigh 1, but for a joint that is
/// slower than an eighth of the median speed limit, e.g. a torso's lift: it weighs median / speed, at most 30, so that
/// metres and radians compare by the time that they take.
JointVector default_joint_weights(const Chain& chain);

/// `weights` divided by the least of them; the defaults when they are empty. Throws std::invalid_argument when they are
/// not one positive number for each joint, or all infinite.
JointVector joint_weights_of(const Chain& chain, const JointVector& weights);

/// 1 / weight^2 of each joint; 0 for a locked one.
JointVector joint_mobility(const JointVector& weights);

}  // namespace multireach::controller
