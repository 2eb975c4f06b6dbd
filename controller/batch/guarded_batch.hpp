#pragma once

#include <vector>

#include "controller/batch/arm_batch.hpp"
#include "controller/batch/guarded_plan.hpp"
#include "controller/guarded_law.hpp"
#include "controller/posture_search.hpp"

namespace multireach::controller {

/// Many arms under the law `guarded`. Each gets bit for bit the motion that GuardedLaw would give it, as long as no
/// angle is beyond 1e5 rad.
class GuardedBatch final : public ArmBatch {
 public:
  /// At least `arms` arms, in whole blocks of kRowLanes, at rest. Throws std::invalid_argument as GuardedLaw does, and
  /// for parameters with a body or acceleration limits.
  GuardedBatch(const Chain& chain, const GuardedParameters& parameters, int arms);

  const ArmBlock& block(int index) const override { return blocks_[static_cast<size_t>(index)]; }
  bool start(int arm, const JointVector& theta, const Eigen::Vector3d& target, const JointVector& theta_target,
             std::optional<double> gamma = {}) override;
  void step() override;

 private:
  void choose_posture(int arm);
  void set_theta_target(GuardedBlock& block, int lane, const JointVector& theta_target);

  GuardedPlan plan_;
  PostureSearch search_;
  std::vector<GuardedBlock> blocks_;
};

}  // namespace multireach::controller
