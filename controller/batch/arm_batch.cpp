#include "controller/batch/arm_batch.hpp"

#include <hwy/highway.h>

#include "kinematics/lanes.hpp"

namespace multireach::controller {

bool ArmBatch::acceptable(int arm, const JointVector& theta, const Eigen::Vector3d& target,
                          const JointVector& theta_target, std::optional<double> gamma) const {
  const auto posture = [&](const JointVector& angles) {
    return angles.size() == chain().size() && angles.allFinite() && angles.cwiseAbs().maxCoeff() <= kLargestAngle;
  };
  return arm >= 0 && arm < size() && posture(theta) && posture(theta_target) &&
         chain().limit_excess(theta_target) <= 0 && target.allFinite() && !(gamma && !(*gamma >= 0 && *gamma <= 1e12));
}

JointVector ArmBatch::theta_of(const ArmBlock& block, int lane, int n) {
  JointVector angles(n);
  for (int i = 0; i < n; ++i) angles[i] = block.joints[static_cast<size_t>(i)].theta[lane];
  return angles;
}

std::vector<std::string> instruction_sets() {
  std::vector<std::string> names;
  hwy::SetSupportedTargetsForTest(0);  // what a test may have chosen
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) names.emplace_back(hwy::TargetName(target));
  return names;
}

std::string instruction_set() {
  const int64_t available = hwy::SupportedTargets() & HWY_TARGETS;
  return hwy::TargetName(available & -available);
}

bool use_instruction_set(const std::string& name) {
  hwy::SetSupportedTargetsForTest(0);
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    if (name != hwy::TargetName(target)) continue;
    hwy::SetSupportedTargetsForTest(target);
    return true;
  }
  return false;
}

}  // namespace multireach::controller
