#include "controller/batch/paper_batch.hpp"

#include <limits>
#include <numbers>
#include <stdexcept>

#include "controller/batch/closed_form_batch.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "controller/batch/paper_batch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "controller/batch/block_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach::controller {
namespace HWY_NAMESPACE {

using multireach::HWY_NAMESPACE::sine_and_cosine;

#include "controller/law/vite.inl.hpp"

#include "controller/law/paper_equations.inl.hpp"

/// One step of the arms `first` to first + kWidth - 1 of a block, like paper_step in law/paper_law.cpp. Returns a mask
/// of the arms whose theta_T has drifted from the target. N: the number of joints, or 0 for any.
template <int N>
LanesMask step_arms(const PaperConstants& constants, ArmBlock& block, int first) {
  constexpr size_t kCapacity = N == 0 ? kMaxJoints : N;
  const int n = N == 0 ? constants.arm.size : N;
  std::array<std::array<Lanes, kCapacity>, 3> J;
  std::array<Lanes, kCapacity> theta, theta_target, weights, velocity, update;
  std::array<Lanes, 3> hand, target, missing;
  const auto get = [first](const Row& row) { return load(row, first); };
  const auto [alpha, beta] = constants.gains;
  const Lanes gamma = get(block.gamma);
  for (int k = 0; k < 3; ++k) {
    target[k] = get(block.target[k]);
    hand[k] = vite_velocity(alpha, beta, get(block.x[k]), get(block.hand_velocity[k]), target[k]);  // (21), (22)
  }
  for (int i = 0; i < n; ++i) {
    const JointRows& joint = block.joints[i];
    theta[i] = get(joint.theta);
    theta_target[i] = get(joint.theta_target);
    velocity[i] = vite_velocity(alpha, beta, theta[i], get(joint.velocity), theta_target[i]);  // (19), (20)
    weights[i] = constants.limit_avoidance ? limit_weight(theta[i], constants.lower[i], constants.upper[i], gamma)
                                           : gamma;  // (28)
    for (int m = 0; m < 3; ++m) J[m][i] = get(joint.jacobian[m]);
  }
  make_coherent(n, J, weights, hand, velocity);                                                      // (23)
  for (int m = 0; m < 3; ++m) store(row_product(n, J, m, velocity), block.hand_velocity[m], first);  // (24)
  for (int i = 0; i < n; ++i) {
    theta[i] += velocity[i];  // (25)
    store(velocity[i], block.joints[i].velocity, first);
    store(theta[i], block.joints[i].theta, first);
    for (int m = 0; m < 3; ++m) J[m][i] = get(block.joints[i].jacobian_target[m]);
  }
  update_kinematics<N, false>(constants.arm, block, first);  // (26)
  for (int m = 0; m < 3; ++m) missing[m] = target[m] - get(block.x_target[m]);
  target_update(n, J, theta_target, theta, missing, update);  // (27)
  for (int i = 0; i < n; ++i) store(theta_target[i] + update[i], block.joints[i].theta_target, first);
  update_kinematics<N, true>(constants.arm, block, first);
  if (constants.drift_m == std::numeric_limits<double>::infinity()) return no_lane();
  Lanes drift2 = 0;
  for (int m = 0; m < 3; ++m) {
    const Lanes drift = target[m] - get(block.x_target[m]);
    drift2 += drift * drift;
  }
  return !(square_root(drift2) <= constants.drift_m);  // NaN counts as drifted
}

uint32_t step_paper(const PaperConstants& constants, ArmBlock& block) {
  return step_block([&](int first) {
    return constants.arm.size == 4 ? step_arms<4>(constants, block, first) : step_arms<0>(constants, block, first);
  });
}

void refresh_paper(const PaperConstants& constants, ArmBlock& block) {
  update_block(constants.arm, block);
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach::controller
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace multireach::controller {
namespace {

PaperConstants constants_of(const Chain& chain, const PaperParameters& parameters, double drift_m) {
  PaperConstants constants{FastLinks<0, double>(chain), parameters.gains, drift_m, parameters.limit_avoidance, {}, {}};
  for (int i = 0; i < chain.size(); ++i) {
    constants.lower[i] = chain.lower()[i];
    constants.upper[i] = chain.upper()[i];
  }
  return constants;
}

}  // namespace

HWY_EXPORT(step_paper);
HWY_EXPORT(refresh_paper);

PaperBatch::PaperBatch(const Chain& chain, const PaperParameters& parameters, double drift_m, int arms)
    : ArmBatch(chain, arms),
      constants_(constants_of(chain, parameters, drift_m)),
      gamma_(parameters.gamma),
      search_(chain) {
  if (!(drift_m >= 0)) throw std::invalid_argument("drift_m must be 0 or more");
  blocks_.resize(running().size());
  reset_all();
}

bool PaperBatch::start(int arm, const JointVector& theta, const Eigen::Vector3d& target,
                       const JointVector& theta_target, std::optional<double> gamma) {
  if (!start_is_valid(arm, theta, target, theta_target, gamma)) return false;
  ArmBlock& block = blocks_[static_cast<size_t>(arm / kRowLanes)];
  const int lane = arm % kRowLanes;
  init_lane(block, lane, theta, target);
  block.gamma[lane] = gamma.value_or(gamma_);
  set_theta_target(arm, theta_target);
  HWY_DYNAMIC_DISPATCH(refresh_paper)(constants_, block);
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
    const uint32_t arms = step_block(constants_, blocks_[b]) & running()[b];
    for (int lane = 0; arms >> lane != 0; ++lane) {
      if (arms >> lane & 1) drifted_.push_back(static_cast<int>(b) * kRowLanes + lane);
    }
  }
  if (!drifted_.empty()) search_theta_targets();
}

void PaperBatch::search_theta_targets() {
  const bool closed_form = search_.closed_form();
  for (size_t from = 0; from < drifted_.size(); from += kRowLanes) {
    const int count = static_cast<int>(std::min<size_t>(kRowLanes, drifted_.size() - from));
    IkQueries queries;
    for (int q = 0; q < count && closed_form; ++q) {
      const ArmBlock& block = blocks_[static_cast<size_t>(drifted_[from + q] / kRowLanes)];
      const int lane = drifted_[from + q] % kRowLanes;
      for (size_t k = 0; k < 3; ++k) queries.x_T[k][q] = block.target[k][lane];
      for (size_t i = 0; i < 4; ++i) queries.theta[i][q] = block.joints[i].theta[lane];
    }
    const uint32_t found = closed_form ? closed_form_batch(search_.closed_form_ik(), queries) : 0;
    for (int q = 0; q < count; ++q) {
      const int arm = drifted_[from + q], lane = arm % kRowLanes;
      const ArmBlock& block = blocks_[static_cast<size_t>(arm / kRowLanes)];
      ++ik_searches_;
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
    HWY_DYNAMIC_DISPATCH(refresh_paper)(constants_, blocks_[static_cast<size_t>(block)]);
  }
}

}  // namespace multireach::controller
#endif
