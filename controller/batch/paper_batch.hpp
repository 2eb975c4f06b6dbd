#pragma once

#include <vector>

#include "controller/batch/arm_batch.hpp"
#include "controller/ik/multi_start.hpp"
#include "controller/law/paper_law.hpp"
#include "kinematics/fast_chain.hpp"

namespace multireach::controller {

/// The constants common to all arms of a batch under the law `paper`.
struct PaperConstants {
  FastLinks<0, double> arm;
  ViteGains gains;
  double drift_m;
  bool limit_avoidance;
  std::array<double, kMaxJoints> lower, upper;
};

/// Many arms under the law `paper`, Eqs. (19)-(28). A step agrees with paper_step to rounding; where Eq. (27) is
/// chaotic, the two diverge after some hundred steps. As in Sect. 3.4, theta_T is searched again when K(theta_T) is
/// further than `drift_m` from the target, or not finite; never when `drift_m` is infinite.
class PaperBatch final : public ArmBatch {
 public:
  /// Creates at least `arms` arms, in whole blocks of kRowLanes, at rest. `drift_m` may be infinite. Throws
  /// std::invalid_argument when it is negative or `arms` is not positive.
  PaperBatch(const Chain& chain, const PaperParameters& parameters, double drift_m, int arms);

  const ArmBlock& block(int index) const override { return blocks_[static_cast<size_t>(index)]; }
  bool start(int arm, const JointVector& theta, const Eigen::Vector3d& target, const JointVector& theta_target,
             std::optional<double> gamma = {}) override;
  void step() override;

 private:
  void search_theta_targets();
  void set_theta_target(int arm, const JointVector& theta_target);

  PaperConstants constants_;
  double gamma_;
  MultiStartIk search_;
  std::vector<ArmBlock> blocks_;
  std::vector<int> drifted_;  // arms whose theta_T must be searched again
};

}  // namespace multireach::controller
