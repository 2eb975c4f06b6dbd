// The hand's task of several arms side by side: kinematics and linear systems.
#if defined(MULTIREACH_CONTROLLER_TASK_LANES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef MULTIREACH_CONTROLLER_TASK_LANES_INL_HPP
#undef MULTIREACH_CONTROLLER_TASK_LANES_INL_HPP
#else
#define MULTIREACH_CONTROLLER_TASK_LANES_INL_HPP
#endif

#include <array>

#include "controller/batch/arm_block.hpp"
#include "kinematics/fast_chain.hpp"
#include "kinematics/wide_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach::controller {
namespace HWY_NAMESPACE {

using multireach::HWY_NAMESPACE::kWidth;
using multireach::HWY_NAMESPACE::Lanes;
using multireach::HWY_NAMESPACE::LanesMask;
using multireach::HWY_NAMESPACE::load;
using multireach::HWY_NAMESPACE::no_lane;

#include "controller/small_solve.inl.hpp"

using Task = std::array<Lanes, 3>;
/// Room for the joints of an arm that has N, or any number (0).
template <int N>
inline constexpr size_t kRoom = N == 0 ? kMaxJoints : N;
/// Room for C joints.
template <size_t C>
using Joints = std::array<Lanes, C>;
/// A Jacobian, by its rows.
template <size_t C>
using Rows = std::array<Joints<C>, 3>;
using Solve = SmallSolve<3, Lanes>;

HWY_INLINE Lanes dot(const Task& a, const Task& b) {
  Lanes sum = 0;
  for (int m = 0; m < 3; ++m) sum += a[m] * b[m];
  return sum;
}

/// Element i of J^T y.
template <size_t C>
HWY_INLINE Lanes column(const std::array<std::array<Lanes, C>, 3>& J, int i, const Task& y) {
  Lanes sum = 0;
  for (int m = 0; m < 3; ++m) sum += J[m][i] * y[m];
  return sum;
}

/// The lower triangle of J J^T.
template <size_t C>
HWY_INLINE Solve::Matrix gram(int n, const std::array<std::array<Lanes, C>, 3>& J) {
  Solve::Matrix A;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c <= r; ++c) {
      Lanes sum = 0;
      for (int i = 0; i < n; ++i) sum += J[r][i] * J[c][i];
      A[r][c] = sum;
    }
  }
  return A;
}

/// The y of (diagonal I + scale J J^T) y = goal - J base.
template <size_t C>
HWY_INLINE Task unbounded(int n, const std::array<std::array<Lanes, C>, 3>& J, Lanes scale, Lanes diagonal,
                          const std::array<Lanes, C>& base, const Task& goal) {
  Task b;
  for (int m = 0; m < 3; ++m) {
    Lanes covered = 0;
    for (int i = 0; i < n; ++i) covered += J[m][i] * base[i];
    b[m] = goal[m] - covered;
  }
  Solve::Matrix A = gram(n, J);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c <= r; ++c) A[r][c] = r == c ? scale * A[r][c] + diagonal : scale * A[r][c];
  }
  return Solve(A).solve(b);
}

/// Writes K and J at the postures of a block: of theta, or of theta_T. Angles of any size.
template <int N, bool kTarget>
HWY_INLINE void place(const FastLinks<0, double>& arm, ArmBlock& block, int first) {
  const int n = N == 0 ? arm.size : N;
  Joints<kRoom<N>> angles;
  for (int i = 0; i < n; ++i) {
    const Lanes angle = load(kTarget ? block.joints[i].theta_target : block.joints[i].theta, first);
    angles[i] = arm.links[i].slides ? angle : within_turns(angle);
  }
  multireach::HWY_NAMESPACE::FastHand<Lanes, kRoom<N>> hand;
  multireach::HWY_NAMESPACE::hand_of<false>(arm, n, angles, hand);
  for (int m = 0; m < 3; ++m) {
    store(hand.position[m], kTarget ? block.x_target[m] : block.x[m], first);
    for (int i = 0; i < n; ++i) {
      JointRows& joint = block.joints[i];
      store(hand.jacobian[m][i], kTarget ? joint.jacobian_target[m] : joint.jacobian[m], first);
    }
  }
}

/// One step of a whole block. Returns a mask: bit a is set for the arm of lane a that Kernel::step returns.
template <class Kernel, class Plan, class Block>
uint32_t step_lanes(const Plan& plan, Block& block) {
  uint32_t arms = 0;
  for (int first = 0; first < kRowLanes; first += kWidth) arms |= bits_of(Kernel(plan, block, first).step()) << first;
  return arms;
}

/// K and J of a whole block, whose theta or theta_T was changed from outside.
inline void place_lanes(const FastLinks<0, double>& arm, ArmBlock& block) {
  for (int first = 0; first < kRowLanes; first += kWidth) {
    place<0, false>(arm, block, first);
    place<0, true>(arm, block, first);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace multireach::controller
HWY_AFTER_NAMESPACE();

#endif
