#include "controller/batch/guarded_batch.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "controller/batch/guarded_batch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "controller/batch/guarded_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach::controller {
namespace HWY_NAMESPACE {

// Unrolled for the Hoap2's four joints. With seven the code would be larger than the processor's instruction cache, and
// no faster than loops.
uint32_t step_guarded(const GuardedPlan& plan, GuardedBlock& block) {
  return plan.arm.size == 4 ? step_lanes<GuardedLanes<4>>(plan, block) : step_lanes<GuardedLanes<0>>(plan, block);
}

void refresh_guarded(const GuardedPlan& plan, GuardedBlock& block) {
  place_lanes(plan.arm, block);
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach::controller
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace multireach::controller {

HWY_EXPORT(step_guarded);
HWY_EXPORT(refresh_guarded);

GuardedBatch::GuardedBatch(const Chain& chain, const GuardedParameters& parameters, int arms)
    : ArmBatch(chain, arms),
      plan_{FastLinks<0, double>(chain, tool_frame(parameters.tool)), guarded_settings(chain, parameters)},
      search_(chain, parameters.posture_search, parameters.tool) {
  if (parameters.body.link_radius_m > 0) throw std::invalid_argument("a batch has no body: link_radius_m must be 0");
  if (parameters.acceleration.size() > 0) throw std::invalid_argument("a batch has no acceleration limits");
  blocks_.resize(running().size());
  rest();
}

bool GuardedBatch::start(int arm, const JointVector& theta, const Eigen::Vector3d& target,
                         const JointVector& theta_target, std::optional<double> gamma) {
  if (!acceptable(arm, theta, target, theta_target, gamma)) return false;
  GuardedBlock& block = blocks_[static_cast<size_t>(arm / kRowLanes)];
  const int lane = arm % kRowLanes;
  const double infinity = std::numeric_limits<double>::infinity();
  begin(block, lane, theta, brought_near(chain(), {.position = target}).position);
  block.largest_gamma[lane] = block.ceiling[lane] = block.gamma[lane] = gamma.value_or(plan_.settings.gamma);
  block.best_distance[lane] = block.stalled_distance[lane] = infinity;
  block.caution[lane] = 1;
  for (Row* row : {&block.idle_steps, &block.waited_steps, &block.steps, &block.residual, &block.out_of_reach}) {
    (*row)[lane] = 0;
  }
  set_theta_target(block, lane, theta_target);
  run(arm);
  return true;
}

void GuardedBatch::set_theta_target(GuardedBlock& block, int lane, const JointVector& theta_target) {
  double distance2 = 0;
  for (int i = 0; i < chain().size(); ++i) {
    block.joints[i].theta_target[lane] = theta_target[i];
    const double apart = theta_target[i] - block.joints[i].theta[lane];
    distance2 += apart * apart;
  }
  block.posture_stuck[lane] = 0;
  block.watched_residual[lane] = std::numeric_limits<double>::infinity();
  block.distance_at_choice[lane] = std::sqrt(distance2);
  block.quiet_until[lane] = block.steps[lane] + GuardedTuning::kQuiet;
  HWY_DYNAMIC_DISPATCH(refresh_guarded)(plan_, block);
}

void GuardedBatch::choose_posture(int arm) {
  GuardedBlock& block = blocks_[static_cast<size_t>(arm / kRowLanes)];
  const int lane = arm % kRowLanes;
  const FoundPosture found = search_.best({.position = target_of(block, lane)}, theta(arm));
  ++posture_choices_;
  block.out_of_reach[lane] = found.error_m > GuardedTuning::kReached ? 1 : 0;
  set_theta_target(block, lane, found.theta);
}

void GuardedBatch::step() {
  const auto step_block = HWY_DYNAMIC_DISPATCH(step_guarded);
  for (size_t b = 0; b < blocks_.size(); ++b) {
    if (running()[b] == 0) continue;
    const uint32_t arms = step_block(plan_, blocks_[b]) & running()[b];
    for (int lane = 0; arms >> lane != 0; ++lane) {
      if (arms >> lane & 1) choose_posture(static_cast<int>(b) * kRowLanes + lane);
    }
  }
}

}  // namespace multireach::controller
#endif
