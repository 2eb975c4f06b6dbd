#pragma once

#include <vector>

#include "controller/batch/arm_batch.hpp"
#include "controller/batch/arm_block.hpp"
#include "controller/ik/multi_start.hpp"
#include "controller/law/guarded_law.hpp"

namespace multireach::controller {

/// The constants common to all arms of a batch under the law `guarded`.
struct GuardedConstants {
  FastLinks<0, double> arm;
  GuardedSettings settings;
};

/// Many arms under the law `guarded`. The motion of each is bit-identical to that of GuardedLaw, as long as no angle is
/// beyond 1e5 rad.
class GuardedBatch final : public ArmBatch {
 public:
  /// Creates at least `arms` arms, in whole blocks of kRowLanes, at rest. Throws std::invalid_argument as GuardedLaw
  /// does, and for parameters with a body.
  GuardedBatch(const Chain& chain, const GuardedParameters& parameters, int arms);

  const ArmBlock& block(int index) const override { return blocks_[static_cast<size_t>(index)]; }
  bool start(int arm, const JointVector& theta, const Eigen::Vector3d& target, const JointVector& theta_target,
             std::optional<double> gamma = {}) override;
  void step() override;

 private:
  void begin_search(int arm);
  void continue_search(int arm);
  void set_theta_target(GuardedBlock& block, int lane, const JointVector& theta_target);

  GuardedConstants constants_;
  MultiStartIk search_;
  std::vector<GuardedBlock> blocks_;
  std::vector<IkSearch> searches_;   // of each arm
  std::vector<uint32_t> searching_;  // a mask for each block: whether theta_T of the arm of lane a is being searched
};

}  // namespace multireach::controller
