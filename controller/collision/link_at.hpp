#pragma once

#include <optional>

#include "controller/collision/body.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

/// Which of the arm's links a position `p` (m, in W) is inside, at joint positions `theta`: the index of the joint that
/// moves it. Nothing where it is in none, or near the end of the arm, three link radii or less, where a target may well
/// be: the hand reaches for it. Also nothing for an arm without a body.
std::optional<int> link_at(const Chain& chain, const Body& body, const JointVector& theta, const Eigen::Vector3d& p);

}  // namespace multireach::controller
