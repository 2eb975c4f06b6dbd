#include "controller/batch/paper_batch.hpp"

#include <limits>
#include <stdexcept>

#include "controller/batch/nearest_postures.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "controller/batch/paper_batch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "controller/batch/paper_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach::controller {
namespace HWY_NAMESPACE {

uint32_t step_paper(const PaperPlan& plan, ArmBlock& block) {
  return plan.arm.size == 4 ? step_lanes<PaperLanes<4>>(plan, block) : step_lanes<PaperLanes<0>>(plan, block);
}

void refresh_paper(const PaperPlan& plan, ArmBlock& block) {
  place_lanes(plan.arm, block);
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach::controller
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace multireach::controller {
namespace {

PaperPlan plan_of(const Chain& chain, const PaperParameters& parameters, double rechoose_m) {
  PaperPlan plan{FastLinks<0, double>(chain), parameters.gains, rechoose_m, parameters.limit_avoidance, {}, {}};
  for (int i = 0; i < chain.size(); ++i) {
    plan.lower[i] = chain.lower()[i];
    plan.upper[i] = chain.upper()[i];
  }
  return plan;
}

}  // namespace

HWY_EXPORT(step_paper);
HWY_EXPORT(refresh_paper);

PaperBatch::PaperBatch(const Chain& chain, const PaperParameters& parameters, double rechoose_m, int arms)
    : ArmBatch(chain, arms), plan_(plan_of(chain, parameters, rechoose_m)), gamma_(parameters.gamma), search_(chain) {
  if (!(rechoose_m >= 0)) throw std::invalid_argument("rechoose_m must be 0 or more");
  blocks_.resize(running().size());
  rest();
}

bool PaperBatch::start(int arm, const JointVector& theta, const Eigen::Vector3d& target,
                       const JointVector& theta_target, std::optional<double> gamma) {
  if (!acceptable(arm, theta, target, theta_target, gamma)) return false;
  ArmBlock& block = blocks_[static_cast<size_t>(arm / kRowLanes)];
  const int lane = arm % kRowLanes;
  begin(block, lane, theta, target);
  block.gamma[lane] = gamma.value_or(gamma_);
  set_theta_target(arm, theta_target);
  HWY_DYNAMIC_DISPATCH(refresh_paper)(plan_, block);
  run(arm);
  return true;
}

void PaperBatch::set_theta_target(int arm, const JointVector& theta_target) {
  ArmBlock& block = blocks_[static_cast<size_t>(arm / kRowLanes)];
  for (int i = 0; i < chain().size(); ++i) block.joints[i].theta_target[arm % kRowLanes] = theta_target[i];
}

void PaperBatch::step() {
  const auto step_block = HWY_DYNAMIC_DISPATCH(step_paper);
  drifted_.clear();
  for (size_t b = 0; b < blocks_.size(); ++b) {
    if (running()[b] == 0) continue;
    const uint32_t arms = step_block(plan_, blocks_[b]) & running()[b];
    for (int lane = 0; arms >> lane != 0; ++lane) {
      if (arms >> lane & 1) drifted_.push_back(static_cast<int>(b) * kRowLanes + lane);
    }
  }
  if (!drifted_.empty()) choose_postures();
}

void PaperBatch::choose_postures() {
  const bool closed_form = search_.closed_form();
  for (size_t from = 0; from < drifted_.size(); from += kRowLanes) {
    const int count = static_cast<int>(std::min<size_t>(kRowLanes, drifted_.size() - from));
    PostureQueries queries;
    for (int q = 0; q < count && closed_form; ++q) {
      const ArmBlock& block = blocks_[static_cast<size_t>(drifted_[from + q] / kRowLanes)];
      const int lane = drifted_[from + q] % kRowLanes;
      for (size_t k = 0; k < 3; ++k) queries.x_T[k][q] = block.target[k][lane];
      for (size_t i = 0; i < 4; ++i) queries.theta[i][q] = block.joints[i].theta[lane];
    }
    const uint32_t found = closed_form ? nearest_postures(search_.shoulder_elbow(), queries) : 0;
    for (int q = 0; q < count; ++q) {
      const int arm = drifted_[from + q], lane = arm % kRowLanes;
      const ArmBlock& block = blocks_[static_cast<size_t>(arm / kRowLanes)];
      ++posture_choices_;
      if (found >> q & 1) {
        JointVector posture(4);
        for (size_t i = 0; i < 4; ++i) posture[static_cast<Eigen::Index>(i)] = queries.posture[i][q];
        set_theta_target(arm, posture);
        continue;
      }
      if (const auto nearest = search_.nearest(target_of(block, lane), theta(arm))) set_theta_target(arm, *nearest);
    }
  }
  for (size_t a = 0; a < drifted_.size(); ++a) {
    const int block = drifted_[a] / kRowLanes;
    if (a > 0 && drifted_[a - 1] / kRowLanes == block) continue;
    HWY_DYNAMIC_DISPATCH(refresh_paper)(plan_, blocks_[static_cast<size_t>(block)]);
  }
}

}  // namespace multireach::controller
#endif
