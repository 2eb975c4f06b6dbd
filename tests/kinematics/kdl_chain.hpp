#pragma once

#include <urdf_parser/urdf_parser.h>

#include <kdl/chain.hpp>
#include <string>
#include <vector>

namespace multireach::testing {

/// The chain between two links as an Orocos KDL chain, built from the URDF without any code of the project. The base
/// must be an ancestor of the tip.
inline KDL::Chain kdl_chain(const std::string& urdf, const std::string& base, const std::string& tip) {
  const auto model = urdf::parseURDF(urdf);
  std::vector<urdf::JointConstSharedPtr> joints;
  for (auto link = model->getLink(tip); link->name != base; link = link->getParent())
    joints.insert(joints.begin(), link->parent_joint);
  KDL::Chain chain;
  for (const auto& joint : joints) {
    const urdf::Pose& pose = joint->parent_to_joint_origin_transform;
    const KDL::Frame frame(
        KDL::Rotation::Quaternion(pose.rotation.x, pose.rotation.y, pose.rotation.z, pose.rotation.w),
        KDL::Vector(pose.position.x, pose.position.y, pose.position.z));
    const KDL::Vector axis = frame.M * KDL::Vector(joint->axis.x, joint->axis.y, joint->axis.z);
    KDL::Joint moving(joint->name, KDL::Joint::None);
    if (joint->type == urdf::Joint::REVOLUTE || joint->type == urdf::Joint::CONTINUOUS) {
      moving = KDL::Joint(joint->name, frame.p, axis, KDL::Joint::RotAxis);
    } else if (joint->type == urdf::Joint::PRISMATIC) {
      moving = KDL::Joint(joint->name, frame.p, axis, KDL::Joint::TransAxis);
    }
    chain.addSegment(KDL::Segment(joint->name, moving, frame));
  }
  return chain;
}

}  // namespace multireach::testing
