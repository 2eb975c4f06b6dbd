#include "controller/batch/arm_batch.hpp"

#include <stdexcept>

#include "numeric/lanes.hpp"

namespace multireach::controller {

ArmBatch::ArmBatch(const Chain& chain, int arms) : chain_(chain) {
  if (arms < 1) throw std::invalid_argument("a batch needs at least one arm");
  running_.resize(static_cast<size_t>((arms + kRowLanes - 1) / kRowLanes));
}

void ArmBatch::reset_all() {
  const JointVector posture = chain().clamped(JointVector::Zero(chain().size()));
  const Eigen::Vector3d hand = chain().position(posture);
  for (int arm = 0; arm < size(); ++arm) {
    start(arm, posture, hand, posture);
    stop(arm);
  }
}

bool ArmBatch::start_is_valid(int arm, const JointVector& theta, const Eigen::Vector3d& target,
                              const JointVector& theta_target, std::optional<double> gamma) const {
  const auto posture = [&](const JointVector& angles) {
    return angles.size() == chain().size() && angles.allFinite() && angles.cwiseAbs().maxCoeff() <= kMaxAngle;
  };
  return arm >= 0 && arm < size() && posture(theta) && posture(theta_target) &&
         chain().limit_excess(theta_target) <= 0 && target.allFinite() && !(gamma && !(*gamma >= 0 && *gamma <= 1e12));
}

void ArmBatch::init_lane(ArmBlock& block, int lane, const JointVector& theta, const Eigen::Vector3d& target) const {
  for (int i = 0; i < chain_.size(); ++i) {
    block.joints[static_cast<size_t>(i)].theta[lane] = theta[i];
    block.joints[static_cast<size_t>(i)].velocity[lane] = 0;
  }
  for (int k = 0; k < 3; ++k) {
    block.hand_velocity[static_cast<size_t>(k)][lane] = 0;
    block.target[static_cast<size_t>(k)][lane] = target[k];
  }
}

JointVector ArmBatch::theta(int arm) const {
  JointVector angles(chain().size());
  for (int i = 0; i < chain().size(); ++i) {
    angles[i] = block(arm / kRowLanes).joints[static_cast<size_t>(i)].theta[arm % kRowLanes];
  }
  return angles;
}

Eigen::Vector3d ArmBatch::x(int arm) const {
  const std::array<Row, 3>& x = block(arm / kRowLanes).x;
  const int lane = arm % kRowLanes;
  return {x[0][lane], x[1][lane], x[2][lane]};
}

}  // namespace multireach::controller
