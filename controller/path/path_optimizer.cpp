#include "controller/path/path_optimizer.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::controller {
namespace {

/// Weight of the squared distance of the last knot from the target. The pull of the path leaves the last knot off the
/// target by a 7200th of the path's length; the planner then corrects it.
constexpr double kEndWeight = 300;
/// Levenberg-Marquardt damping, m^2: the first, and its factors after a step that fails and one that succeeds.
constexpr double kFirstDamping = 1e-4, kDampingRise = 8, kDampingFall = 0.3, kMaxDamping = 1e6;
/// A relative decrease of the objective below this ends the optimisation.
constexpr double kConverged = 1e-4;
/// Number of knots over which the margin grows from 0 at either end.
constexpr double kMarginKnots = 4;

double squared(double value) {
  return value * value;
}

}  // namespace

PathOptimizer::PathOptimizer(const Chain& chain, const std::array<double, kMaxJoints>& mobility)
    : links_(chain), mobility_(mobility), knots_(kSegments + 1) {
  for (int i = 0; i < chain.size(); ++i) {
    lower_[i] = chain.lower()[i];
    upper_[i] = chain.upper()[i];
  }
}

void PathOptimizer::begin(const JointPath& path, const Eigen::Vector3d& target, double gamma, double margin) {
  path_ = path;
  target_ = {target[0], target[1], target[2]};
  joint_weight_ = 1 / gamma;
  damping_ = kFirstDamping;
  linearized_ = false;
  for (size_t k = 1; k <= kSegments; ++k) {
    Knot& knot = knots_[k];
    const double from_end = static_cast<double>(std::min(k, kSegments - k));
    for (int i = 0; i < links_.size; ++i) {
      const double room = std::min(margin * std::min(1.0, from_end / kMarginKnots), 0.25 * (upper_[i] - lower_[i]));
      const double start = path.knots[0][i];
      knot.lower[i] = lower_[i] + std::clamp(start - lower_[i], 0.0, room);
      knot.upper[i] = upper_[i] - std::clamp(upper_[i] - start, 0.0, room);
      const double at = path.knots[k][i];
      if (moves(i)) path_.knots[k][i] = std::clamp(at, knot.lower[i], knot.upper[i]);
    }
  }
  objective_ = evaluate(path_);
}

double PathOptimizer::evaluate(const JointPath& path) {
  const int n = links_.size;
  FastHand<double, kMaxJoints> hand;
  double sum = 0;
  for (size_t k = 0; k <= kSegments; ++k) {
    Knot& knot = knots_[k];
    forward_kinematics<false>(links_, n, path.knots[k], hand);
    knot.x = hand.position;
    for (size_t m = 0; m < 3; ++m) knot.jacobian[m] = hand.jacobian[m];
    if (k == 0) continue;
    for (size_t m = 0; m < 3; ++m) sum += squared(knot.x[m] - knots_[k - 1].x[m]);
    for (int i = 0; i < n; ++i) {
      if (mobility_[i] > 0) sum += joint_weight_ / mobility_[i] * squared(path.knots[k][i] - path.knots[k - 1][i]);
    }
  }
  for (size_t m = 0; m < 3; ++m) sum += kEndWeight * squared(target_[m] - knots_[kSegments].x[m]);
  return sum;
}

void PathOptimizer::linearize() {
  const int n = links_.size;
  for (size_t k = 1; k <= kSegments; ++k) {
    Knot& knot = knots_[k];
    const bool last = k == kSegments;
    const double hands = last ? 1 + kEndWeight : 2, neighbours = last ? 1 : 2;
    std::array<double, 3> pull;
    for (size_t m = 0; m < 3; ++m) {
      pull[m] = knot.x[m] - knots_[k - 1].x[m];
      pull[m] += last ? kEndWeight * (knot.x[m] - target_[m]) : knot.x[m] - knots_[k + 1].x[m];
    }
    const auto& J = knot.jacobian;
    for (int i = 0; i < n; ++i) {
      const double weight = mobility_[i] > 0 ? joint_weight_ / mobility_[i] : 0;
      double stretch = path_.knots[k][i] - path_.knots[k - 1][i];
      if (!last) stretch += path_.knots[k][i] - path_.knots[k + 1][i];
      knot.gradient[i] = weight * stretch + J[0][i] * pull[0] + J[1][i] * pull[1] + J[2][i] * pull[2];
      for (int j = i; j < n; ++j) {
        knot.diagonal[i][j] = hands * (J[0][i] * J[0][j] + J[1][i] * J[1][j] + J[2][i] * J[2][j]);
      }
      knot.diagonal[i][i] += neighbours * weight;
      if (last) continue;
      const auto& next = knots_[k + 1].jacobian;
      for (int j = 0; j < n; ++j) {
        knot.coupling[i][j] = -(J[0][i] * next[0][j] + J[1][i] * next[1][j] + J[2][i] * next[2][j]);
      }
      knot.coupling[i][i] -= weight;
    }
  }
}

void PathOptimizer::exclude_blocked() {
  for (size_t k = 1; k <= kSegments; ++k) {
    Knot& knot = knots_[k];
    for (int i = 0; i < links_.size; ++i) {
      const double at = path_.knots[k][i], gradient = knot.gradient[i];
      const bool blocked = (at <= knot.lower[i] && gradient > 0) || (at >= knot.upper[i] && gradient < 0);
      knot.free[i] = blocked || !moves(i) ? 0 : 1;
    }
  }
}

/// Block-tridiagonal Cholesky factorisation and solution, without the joints that are not free. The inner loops run
/// along rows, so that the compiler can use SIMD registers without changing the order of a sum. Returns false when the
/// matrix is not positive definite.
bool PathOptimizer::solve() {
  const int n = links_.size;
  Matrix A;  // upper triangle of the knot's block
  for (size_t k = 1; k <= kSegments; ++k) {
    Knot& knot = knots_[k];
    Joints& y = knot.step;
    for (int i = 0; i < n; ++i) {
      for (int j = i; j < n; ++j) A[i][j] = knot.free[i] * knot.free[j] * knot.diagonal[i][j];
      A[i][i] += knot.free[i] > 0 ? damping_ : 1;
      y[i] = -knot.free[i] * knot.gradient[i];
    }
    for (int c = 0; c < n && k > 1; ++c) {
      const Joints& row = knots_[k - 1].coupling_factor[c];
      const double before = knots_[k - 1].step[c];
      for (int i = 0; i < n; ++i) {
        const double factor = row[i];
        for (int j = i; j < n; ++j) A[i][j] -= factor * row[j];
        y[i] -= factor * before;
      }
    }
    Matrix& U = knot.factor;
    for (int c = 0; c < n; ++c) {
      if (!(A[c][c] > 0)) return false;
      const double inverse = knot.inverse[c] = 1 / std::sqrt(A[c][c]);
      for (int j = c; j < n; ++j) U[c][j] = A[c][j] * inverse;
      y[c] *= inverse;
      for (int i = c + 1; i < n; ++i) {
        const double factor = U[c][i];
        for (int j = i; j < n; ++j) A[i][j] -= factor * U[c][j];
        y[i] -= factor * y[c];
      }
    }
    if (k == kSegments) break;
    Matrix& T = knot.coupling_factor;
    for (int c = 0; c < n; ++c) {
      for (int r = 0; r < n; ++r) T[c][r] = knot.free[c] * knots_[k + 1].free[r] * knot.coupling[c][r];
      for (int d = 0; d < c; ++d) {
        const double factor = U[d][c];
        for (int r = 0; r < n; ++r) T[c][r] -= factor * T[d][r];
      }
      for (int r = 0; r < n; ++r) T[c][r] *= knot.inverse[c];
    }
  }
  for (size_t k = kSegments; k >= 1; --k) {
    Knot& knot = knots_[k];
    Joints& y = knot.step;
    for (int i = n - 1; i >= 0; --i) {
      for (int r = 0; r < n && k < kSegments; ++r) y[i] -= knot.coupling_factor[i][r] * knots_[k + 1].step[r];
      for (int c = i + 1; c < n; ++c) y[i] -= knot.factor[i][c] * y[c];
      y[i] *= knot.inverse[i];
    }
  }
  return true;
}

bool PathOptimizer::improve() {
  if (!linearized_) {
    linearize();
    exclude_blocked();
    linearized_ = true;
  }
  if (solve()) {
    trial_ = path_;
    for (size_t k = 1; k <= kSegments; ++k) {
      const Knot& knot = knots_[k];
      for (int i = 0; i < links_.size; ++i) {
        if (knot.free[i] > 0) {
          trial_.knots[k][i] = std::clamp(path_.knots[k][i] + knot.step[i], knot.lower[i], knot.upper[i]);
        }
      }
    }
    // Afterwards x and jacobian are those of the trial; a failed trial needs only the blocks, which are those of path_.
    const double objective = evaluate(trial_);
    if (objective < objective_) {
      const bool converged = objective_ - objective < kConverged * objective_;
      path_ = trial_;
      objective_ = objective;
      damping_ *= kDampingFall;
      linearized_ = false;
      return !converged;
    }
  }
  damping_ *= kDampingRise;
  return damping_ < kMaxDamping;
}

}  // namespace multireach::controller
