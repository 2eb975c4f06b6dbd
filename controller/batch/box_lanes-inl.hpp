// Linear systems and the bounded program of many arms side by side: BoxProgram of box_program.hpp with its operations
// in the same order, and masks where it branches.
#if defined(MULTIREACH_CONTROLLER_BOX_LANES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef MULTIREACH_CONTROLLER_BOX_LANES_INL_HPP
#undef MULTIREACH_CONTROLLER_BOX_LANES_INL_HPP
#else
#define MULTIREACH_CONTROLLER_BOX_LANES_INL_HPP
#endif

#include "controller/batch/task_lanes-inl.hpp"
#include "controller/box_program.hpp"

HWY_BEFORE_NAMESPACE();
namespace multireach::controller {
namespace HWY_NAMESPACE {

/// See BoxProgram, whose names these are.
template <size_t C>
struct BoxLanes {
  using Joints = HWY_NAMESPACE::Joints<C>;

  int n;
  Lanes gamma;
  const Rows<C>& jacobian;
  const Joints& wanted;
  const Task& hand;
  const Joints &lower, &upper;

  /// Writes the bounded velocity of the arms in `arms`; the others keep theirs.
  HWY_NOINLINE void solve(Task multiplier, LanesMask arms, Joints& result) const {
    Task residual;
    Joints held, v, next_held, next_v;
    velocity(multiplier, residual, held, v);
    for (int iterations = 0; iterations < BoxProgram<3, kMaxJoints>::kMost; ++iterations) {
      const Task full = newton(held);
      Task stride, next = full, next_residual;
      for (int m = 0; m < 3; ++m) stride[m] = full[m] - multiplier[m];
      const Lanes slope = dot(stride, residual);
      const LanesMask ended = arms & !(slope > 0);
      take(ended, v, result);
      arms = arms & !ended;
      if (!any(arms)) return;
      velocity(next, next_residual, next_held, next_v);
      const LanesMask cut = arms & differ(next_held, held) & (dot(stride, next_residual) < 0);
      if (any(cut)) shorten(cut, multiplier, stride, slope, next, next_residual, next_held, next_v);
      LanesMask solved = !differ(next_held, held);
      for (int m = 0; m < 3; ++m) solved = solved & (next[m] == full[m]);
      v = next_v;
      take(arms & solved, v, result);
      arms = arms & !solved;
      if (!any(arms)) return;
      multiplier = next;
      residual = next_residual;
      held = next_held;
    }
    take(arms, v, result);
  }

 private:
  void take(LanesMask arms, const Joints& from, Joints& to) const {
    for (int i = 0; i < n; ++i) to[i] = where(arms, from[i], to[i]);
  }

  LanesMask differ(const Joints& a, const Joints& b) const {
    LanesMask same = a[0] == b[0];
    for (int i = 1; i < n; ++i) same = same & (a[i] == b[i]);
    return !same;
  }

  /// Halves the stride of the arms in `cut` towards where the dual is flat, from below.
  HWY_NOINLINE void shorten(LanesMask cut, const Task& multiplier, const Task& stride, Lanes slope, Task& next,
                            Task& next_residual, Joints& next_held, Joints& next_v) const {
    Lanes below = 0, above = 1;
    for (int k = 0; k < BoxProgram<3, kMaxJoints>::kHalvings && any(cut); ++k) {
      const Lanes middle = 0.5 * (below + above);
      Task tried, tried_residual;
      Joints tried_held, tried_v;
      for (int m = 0; m < 3; ++m) tried[m] = multiplier[m] + middle * stride[m];
      velocity(tried, tried_residual, tried_held, tried_v);
      const Lanes left = dot(stride, tried_residual);
      for (int m = 0; m < 3; ++m) {
        next[m] = where(cut, tried[m], next[m]);
        next_residual[m] = where(cut, tried_residual[m], next_residual[m]);
      }
      take(cut, tried_held, next_held);
      take(cut, tried_v, next_v);
      const LanesMask over = left < 0;
      above = where(over, middle, above);
      below = where(over, below, middle);
      cut = cut & !((left >= 0) & (left <= 0.5 * slope));
    }
  }

  void velocity(const Task& multiplier, Task& residual, Joints& held, Joints& v) const {
    for (int m = 0; m < 3; ++m) residual[m] = hand[m] - multiplier[m];
    for (int i = 0; i < n; ++i) {
      const Lanes u = wanted[i] + gamma * column(jacobian, i, multiplier);
      v[i] = clamped(u, lower[i], upper[i]);
      held[i] = where((u < lower[i]) | (lower[i] == upper[i]), -1, where(u > upper[i], 1, 0));
      for (int m = 0; m < 3; ++m) residual[m] -= jacobian[m][i] * v[i];
    }
  }

  Task newton(const Joints& held) const {
    Solve::Matrix A;
    Task b = hand;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c <= r; ++c) A[r][c] = r == c ? 1 : 0;
    }
    for (int i = 0; i < n; ++i) {
      const LanesMask free = held[i] == 0;
      const Lanes fixed = where(held[i] < 0, lower[i], where(held[i] > 0, upper[i], wanted[i]));
      for (int r = 0; r < 3; ++r) {
        b[r] -= jacobian[r][i] * fixed;
        for (int c = 0; c <= r; ++c) A[r][c] += where(free, gamma * jacobian[r][i] * jacobian[c][i], 0);
      }
    }
    return Solve(A).solve(b);
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace multireach::controller
HWY_AFTER_NAMESPACE();

#endif
