#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "controller/collision/proximity.hpp"
#include "numeric/interval.hpp"

namespace multireach::controller {

/// Coherence under joint velocity bounds, with collision avoidance as a soft constraint:
///
///   minimise |D^-1/2 (v - wanted)|^2 + gamma |J v - hand|^2 + weight * sum_r max(0, floor_r - gradient_r v)^2
///   over     lower_i <= v_i <= upper_i:
///
/// the program of BoxQp with a stiff penalty on every clearance that would shrink faster than allowed. Joint bounds are
/// hard and take precedence over clearances. The cost is convex and piecewise quadratic. The solver is Newton's method
/// projected on the bounds (Bertsekas, SIAM J. Control and Optimization 20, 1982). Where the projected step does not
/// reduce the cost enough, it takes an active-set step instead: along the same direction to the first bound.
template <int kCapacity>
struct SoftCollisionQp {
  using Joints = std::array<double, kCapacity>;

  int n;
  int rows;  ///< of the task: 3 to 6
  double gamma;
  std::array<Joints, 6> jacobian;
  Joints wanted;
  std::array<double, 6> hand;
  Joints lower, upper;
  std::span<const ProximityPair> pairs;
  double rate;         ///< largest relative decrease of a clearance per step
  Joints stiffness{};  ///< the diagonal of D^-1; positive

  /// D^-1 of joints of this mobility. A locked joint, of mobility 0, has equal bounds; its stiffness does not matter.
  static Joints stiffness_of(const std::array<double, kMaxJoints>& mobility) {
    Joints stiffness{};
    for (size_t i = 0; i < stiffness.size(); ++i) stiffness[i] = mobility[i] > 0 ? 1 / mobility[i] : 1;
    return stiffness;
  }

  /// `v`: the start value; the solution on return. Returns the number of linear systems solved.
  [[gnu::noinline]] int solve(Joints& v) const {
    for (int i = 0; i < n; ++i) v[i] = std::clamp(v[i], lower[i], upper[i]);
    int iterations = 0;
    while (iterations < kMost) {
      std::array<Joints, kCapacity> H;
      Joints gradient;
      differentiate(v, gradient, H);
      Joints stride = newton(v, gradient, H, iterations);
      double slope = 0;  // half the directional derivative of the cost along the step
      for (int i = 0; i < n; ++i) slope += gradient[i] * stride[i];
      if (!(slope < 0)) break;
      Joints projected = v;
      double promised = 0;
      for (int i = 0; i < n; ++i) {
        projected[i] = std::clamp(v[i] + stride[i], lower[i], upper[i]);
        promised += gradient[i] * (v[i] - projected[i]);
      }
      const double cost = cost_of(v);
      const bool last = -slope < 1e-13 * cost;  // the remaining decrease is below the rounding of the cost
      if (last || (promised > 0 && cost_of(projected) < cost - 1e-4 * promised)) {
        v = projected;
      } else {
        v = along(v, stride, slope);
      }
      if (last) break;
    }
    return iterations;
  }

 private:
  static constexpr int kMost = 60;
  static constexpr int kHalvings = 40;
  static constexpr double kWeight = 1e6;  // rad^2/m^2: stiff compared with gamma, some 100

  /// The Newton step, without the joints at a bound that the descent direction or the step itself would cross.
  Joints newton(const Joints& v, const Joints& gradient, const std::array<Joints, kCapacity>& H,
                int& iterations) const {
    std::array<bool, kCapacity> held{};
    for (int i = 0; i < n; ++i) {
      held[i] = lower[i] == upper[i] || leads_out(v[i], lower[i], upper[i], -gradient[i]);
    }
    using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kCapacity, kCapacity>;
    using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kCapacity, 1>;
    for (;;) {
      Matrix free(n, n);
      Vector solution(n);
      for (int i = 0; i < n; ++i) {
        solution[i] = held[i] ? 0 : -gradient[i];
        for (int k = 0; k < n; ++k) free(i, k) = held[i] || held[k] ? (i == k ? 1 : 0) : H[i][k];
      }
      free.llt().solveInPlace(solution);  // positive definite: H is at least D^-1
      Joints stride{};
      for (int i = 0; i < n; ++i) stride[i] = solution[i];
      ++iterations;
      bool more = false;
      for (int i = 0; i < n; ++i) {
        if (leads_out(v[i], lower[i], upper[i], stride[i]) && !held[i]) more = held[i] = true;
      }
      if (!more) return stride;
    }
  }

  /// Line search along the step up to the first bound; stops earlier near the minimum of the cost.
  Joints along(const Joints& v, const Joints& stride, double slope) const {
    double above = 1;
    for (int i = 0; i < n; ++i) {
      const double bound = stride[i] < 0 ? lower[i] : upper[i];
      if (stride[i] != 0) above = std::min(above, (bound - v[i]) / stride[i]);
    }
    double below = 0, share = above;
    Joints candidate = v;
    for (int k = 0; k < kHalvings; ++k) {
      for (int i = 0; i < n; ++i) {
        candidate[i] = std::clamp(v[i] + share * stride[i], lower[i], upper[i]);
      }
      const double left = slope_at(candidate, stride);
      if (left <= 0 && (share == above || left >= 0.1 * slope)) break;
      (left > 0 ? above : below) = share;
      share = 0.5 * (below + above);
    }
    return candidate;
  }

  double slope_at(const Joints& v, const Joints& stride) const {
    const auto product = [&](const auto& row) {
      double sum = 0;
      for (int i = 0; i < n; ++i) sum += row[i] * stride[i];
      return sum;
    };
    double slope = 0;
    for (int i = 0; i < n; ++i) slope += stiffness[i] * (v[i] - wanted[i]) * stride[i];
    for (int m = 0; m < rows; ++m) slope += gamma * hand_error(m, v) * product(jacobian[m]);
    for (const ProximityPair& pair : pairs) slope -= kWeight * shortfall(pair, v) * product(pair.gradient);
    return slope;
  }

  double shortfall(const ProximityPair& pair, const Joints& v) const {
    double sum = -rate * pair.clearance;
    for (int i = 0; i < n; ++i) sum -= pair.gradient[i] * v[i];
    return std::max(0.0, sum);
  }

  double hand_error(int m, const Joints& v) const {
    double sum = -hand[m];
    for (int i = 0; i < n; ++i) sum += jacobian[m][i] * v[i];
    return sum;
  }

  double cost_of(const Joints& v) const {
    double cost = 0;
    for (int i = 0; i < n; ++i) cost += stiffness[i] * (v[i] - wanted[i]) * (v[i] - wanted[i]);
    for (int m = 0; m < rows; ++m) {
      const double error = hand_error(m, v);
      cost += gamma * error * error;
    }
    for (const ProximityPair& pair : pairs) {
      const double missing = shortfall(pair, v);
      cost += kWeight * missing * missing;
    }
    return cost;
  }

  /// Computes half the gradient and half the Hessian of the cost.
  void differentiate(const Joints& v, Joints& gradient, std::array<Joints, kCapacity>& H) const {
    for (int i = 0; i < n; ++i) {
      gradient[i] = stiffness[i] * (v[i] - wanted[i]);
      for (int k = 0; k < n; ++k) H[i][k] = i == k ? stiffness[i] : 0;
    }
    const auto add = [&](const auto& row, double weight, double error) {
      for (int i = 0; i < n; ++i) {
        gradient[i] += weight * error * row[i];
        for (int k = 0; k <= i; ++k) H[i][k] += weight * row[i] * row[k];
      }
    };
    for (int m = 0; m < rows; ++m) add(jacobian[m], gamma, hand_error(m, v));
    for (const ProximityPair& pair : pairs) {
      const double missing = shortfall(pair, v);
      if (missing > 0) add(pair.gradient, kWeight, -missing);
    }
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < i; ++k) H[k][i] = H[i][k];
    }
  }
};

}  // namespace multireach::controller
