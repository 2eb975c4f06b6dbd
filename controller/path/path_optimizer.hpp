#pragma once

#include <array>
#include <vector>

#include "controller/path/joint_path.hpp"
#include "kinematics/fast_chain.hpp"

namespace multireach::controller {

/// Shortens the path of the hand: moves the knots q_k of a joint path, except the first, inside the joint limits. It
/// minimises the paper's objective (6), summed over the whole reach,
///
///     sum |x_k - x_{k-1}|^2  +  1/gamma sum |q_k - q_{k-1}|^2_W  +  300 |x_T - x_K|^2,    x_k = K(q_k),
///
/// where W holds the squared weights of the joints, by Gauss-Newton steps with Levenberg-Marquardt damping that exclude
/// joints blocked by their limits (Nocedal & Wright, Numerical Optimization, 2006, Sects. 10.3, 16.7). The first sum is
/// least when the hand's path is short and its knots are evenly spaced. A step solves one block-tridiagonal system. The
/// result is a local minimum. Allocates all memory at construction.
class PathOptimizer {
 public:
  /// Joints of a smaller mobility, 1 / weight^2, are heavy, e.g. a torso's slow lift: they stay as the path has them.
  static constexpr double kHeavyMobility = 0.1;

  /// `mobility`: 1 / weight^2 of each joint; 0 for a locked one.
  PathOptimizer(const Chain& chain, const std::array<double, kMaxJoints>& mobility);

  /// Begins with `path`, towards `target` (m, in W). `gamma`: rad^2/m^2. The knots between keep `margin` (rad or m)
  /// from the joint limits, less so near both ends, and where the start is nearer.
  void begin(const JointPath& path, const Eigen::Vector3d& target, double gamma, double margin);
  /// One Gauss-Newton step. Returns false when it has converged or cannot improve the path.
  bool improve();
  const JointPath& path() const { return path_; }

 private:
  static constexpr size_t kSegments = JointPath::kSegments;
  using Joints = std::array<double, kMaxJoints>;
  using Matrix = std::array<Joints, kMaxJoints>;

  /// What belongs to one knot.
  struct Knot {
    Joints lower, upper;  // bounds of the knot
    std::array<double, 3> x;
    std::array<Joints, 3> jacobian;
    Joints gradient, step;
    Joints free;  // 0 for a joint at a bound that the gradient would lead out, else 1
    // Blocks of the normal equations; `coupling` has the rows of this knot and the columns of the next.
    Matrix diagonal, coupling;
    Matrix factor, coupling_factor;  // upper triangular factor
    Joints inverse;                  // of the factor's diagonal
  };

  /// Computes x and jacobian of all knots. Returns the objective.
  double evaluate(const JointPath& path);
  bool moves(int joint) const { return mobility_[static_cast<size_t>(joint)] >= kHeavyMobility; }
  void linearize();
  void exclude_blocked();
  bool solve();

  FastLinks<0, double> links_;
  Joints lower_, upper_, mobility_;
  std::array<double, 3> target_{};
  double joint_weight_ = 0, objective_ = 0, damping_ = 0;
  bool linearized_ = false;
  JointPath path_, trial_;
  std::vector<Knot> knots_;
};

}  // namespace multireach::controller
