#pragma once

#include <array>
#include <cmath>

#include "controller/joint_bounds.hpp"
#include "controller/small_solve.hpp"

namespace multireach::controller {

/// Coherence under bounds, the quadratic program
///
///   minimise |v - wanted|^2 + gamma |J v - hand|^2   over  range_i.lower <= v_i <= range_i.upper,
///
/// Eq. (6) with W_x = I and W_theta^-1 = gamma I. With lambda = gamma (hand - J v) its solution is
/// v = clamp(wanted + J^T lambda), so the M unknowns lambda satisfy a piecewise linear, strongly monotone equation: the
/// stationarity of the convex dual cost. It is solved by Newton's method from the unbounded solution; where a full
/// stride would overshoot, the stride is cut where the dual stops falling. It ends when no joint comes to or leaves a
/// bound any more, which is then the solution; whatever lambda it ends with, v is inside the bounds.
template <int M, int kCapacity>
struct BoxProgram {
  using Task = std::array<double, M>;
  using Joints = std::array<double, kCapacity>;
  static constexpr int kMost = 60;      // linear systems
  static constexpr int kHalvings = 50;  // of one stride

  int n;
  double gamma;
  std::array<Joints, M> jacobian;
  Joints wanted;
  Task hand;
  std::array<VelocityRange, kCapacity> range;

  /// The velocity; `multiplier` is lambda / gamma of the unbounded program on entry, and of the bounded one on return.
  /// `iterations` counts the linear systems that were solved.
  Joints solve(Task& multiplier, int& iterations) const {
    Task residual;
    Held held;
    Joints v = velocity(multiplier, residual, held);
    for (iterations = 0; iterations < kMost;) {
      const Task full = newton(held);
      ++iterations;
      Task stride, next = full, next_residual;
      for (int m = 0; m < M; ++m) stride[m] = full[m] - multiplier[m];
      const double slope = dot(stride, residual);
      if (!(slope > 0)) break;
      Held next_held;
      v = velocity(next, next_residual, next_held);
      // Overshot where the dual rises again; then the stride is halved towards where it is flat, from below.
      if (next_held != held && dot(stride, next_residual) < 0) {
        double below = 0, above = 1;
        for (int k = 0; k < kHalvings; ++k) {
          const double middle = 0.5 * (below + above);
          for (int m = 0; m < M; ++m) next[m] = multiplier[m] + middle * stride[m];
          v = velocity(next, next_residual, next_held);
          const double left = dot(stride, next_residual);
          (left < 0 ? above : below) = middle;
          if (left >= 0 && left <= 0.5 * slope) break;
        }
      }
      const bool solved = next_held == held && next == full;
      multiplier = next;
      residual = next_residual;
      held = next_held;
      if (solved) break;
    }
    return v;
  }

 private:
  /// Where each joint stands: below its range, in it, above it; a joint without freedom is always below.
  using Held = std::array<signed char, kCapacity>;

  static double dot(const Task& a, const Task& b) {
    double sum = 0;
    for (int m = 0; m < M; ++m) sum += a[m] * b[m];
    return sum;
  }

  double free_velocity(const Task& multiplier, int i) const {
    double pull = 0;
    for (int m = 0; m < M; ++m) pull += jacobian[m][i] * multiplier[m];
    return wanted[i] + gamma * pull;
  }

  /// v for a multiplier, what the multiplier lacks of hand - J v (the dual's descent, over gamma), and who is held.
  Joints velocity(const Task& multiplier, Task& residual, Held& held) const {
    Joints v;
    held = {};
    for (int m = 0; m < M; ++m) residual[m] = hand[m] - multiplier[m];
    for (int i = 0; i < n; ++i) {
      const double u = free_velocity(multiplier, i);
      v[i] = std::clamp(u, range[i].lower, range[i].upper);
      held[i] = u < range[i].lower || range[i].lower == range[i].upper ? -1 : u > range[i].upper ? 1 : 0;
      for (int m = 0; m < M; ++m) residual[m] -= jacobian[m][i] * v[i];
    }
    return v;
  }

  /// The solution if these joints stay at their bounds and no others.
  Task newton(const Held& held) const {
    typename SmallSolve<M, double>::Matrix A;
    Task b = hand;
    for (int r = 0; r < M; ++r) {
      for (int c = 0; c <= r; ++c) A[r][c] = r == c ? 1 : 0;
    }
    for (int i = 0; i < n; ++i) {
      const double fixed = held[i] < 0 ? range[i].lower : held[i] > 0 ? range[i].upper : wanted[i];
      for (int r = 0; r < M; ++r) {
        b[r] -= jacobian[r][i] * fixed;
        if (held[i] != 0) continue;
        for (int c = 0; c <= r; ++c) A[r][c] += gamma * jacobian[r][i] * jacobian[c][i];
      }
    }
    return SmallSolve<M, double>(A).solve(b);
  }
};

}  // namespace multireach::controller
