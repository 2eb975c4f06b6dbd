// Computation on the arms of a block, as many at once as a register has lanes: load and store as Lanes, kinematics, and
// the step loop common to all laws.
#if defined(MULTIREACH_CONTROLLER_BLOCK_LANES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef MULTIREACH_CONTROLLER_BLOCK_LANES_INL_HPP
#undef MULTIREACH_CONTROLLER_BLOCK_LANES_INL_HPP
#else
#define MULTIREACH_CONTROLLER_BLOCK_LANES_INL_HPP
#endif

#include <array>

#include "controller/batch/arm_block.hpp"
#include "kinematics/wide_hand-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach::controller {
namespace HWY_NAMESPACE {

using multireach::HWY_NAMESPACE::kWidth;
using multireach::HWY_NAMESPACE::Lanes;
using multireach::HWY_NAMESPACE::LanesMask;
using multireach::HWY_NAMESPACE::load;
using multireach::HWY_NAMESPACE::no_lane;
using multireach::HWY_NAMESPACE::store;

#include "numeric/small_solve.inl.hpp"

/// Computes K and J of a block at theta or, with kTarget, at theta_T, for angles of any size. N: the number of joints,
/// or 0 for any.
template <int N, bool kTarget>
HWY_INLINE void update_kinematics(const FastLinks<0, double>& arm, ArmBlock& block, int first) {
  constexpr size_t kCapacity = N == 0 ? kMaxJoints : N;
  const int n = N == 0 ? arm.size : N;
  std::array<Lanes, kCapacity> angles;
  for (int i = 0; i < n; ++i) {
    const Lanes angle = load(kTarget ? block.joints[i].theta_target : block.joints[i].theta, first);
    angles[i] = arm.links[i].is_prismatic ? angle : wrapped_angle(angle);
  }
  multireach::HWY_NAMESPACE::FastHand<Lanes, kCapacity> hand;
  multireach::HWY_NAMESPACE::forward_kinematics<false>(arm, n, angles, hand);
  for (int m = 0; m < 3; ++m) {
    store(hand.position[m], kTarget ? block.x_target[m] : block.x[m], first);
    for (int i = 0; i < n; ++i) {
      JointRows& joint = block.joints[i];
      store(hand.jacobian[m][i], kTarget ? joint.jacobian_target[m] : joint.jacobian[m], first);
    }
  }
}

/// Computes K and J of a whole block at theta and theta_T. Call it after changing either outside a step.
inline void update_block(const FastLinks<0, double>& arm, ArmBlock& block) {
  for (int first = 0; first < kRowLanes; first += kWidth) {
    update_kinematics<0, false>(arm, block, first);
    update_kinematics<0, true>(arm, block, first);
  }
}

/// One step of a whole block. `step(first)` computes kWidth arms from lane `first` on and returns a mask of them.
/// Returns these masks as bits: bit a belongs to lane a.
template <class Step>
uint32_t step_block(Step&& step) {
  uint32_t arms = 0;
  for (int first = 0; first < kRowLanes; first += kWidth) arms |= bits_of(step(first)) << first;
  return arms;
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach::controller
HWY_AFTER_NAMESPACE();

#endif
