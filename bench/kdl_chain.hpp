#pragma once

#include <kdl/chain.hpp>

#include "kinematics/chain.hpp"

namespace multireach::bench {

/// The same chain for Orocos KDL; all joints must be revolute.
inline KDL::Chain kdl_chain(const Chain& chain) {
  const auto frame = [](const Eigen::Isometry3d& X) {
    const Eigen::Quaterniond q(X.linear());
    return KDL::Frame(KDL::Rotation::Quaternion(q.x(), q.y(), q.z(), q.w()),
                      KDL::Vector(X.translation().x(), X.translation().y(), X.translation().z()));
  };
  KDL::Chain arm;
  for (int i = 0; i < chain.size(); ++i) {
    const KDL::Frame before = frame(chain.fixed(i));
    const Eigen::Vector3d& axis = chain.joint(i).axis;
    const KDL::Vector turned = before.M * KDL::Vector(axis.x(), axis.y(), axis.z());
    arm.addSegment(KDL::Segment(KDL::Joint(before.p, turned, KDL::Joint::RotAxis), before));
  }
  arm.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), frame(chain.fixed(chain.size()))));
  return arm;
}

}  // namespace multireach::bench
