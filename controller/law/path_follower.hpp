#pragma once

#include <array>

#include "controller/law/guarded_step.hpp"
#include "controller/path/joint_path.hpp"

namespace multireach::controller {

/// Moves an arm along a joint path: computes the joint velocity of the next step. The distance covered, in joint space,
/// follows the joints' attractor, Eqs. (19), (20); it waits where a joint cannot follow within its bounds
/// (docs/guarantees.md, Sect. 1). Allocates no memory.
class PathFollower {
 public:
  /// Begins a path; its first knot is where the arm of `state` is, which may move.
  void begin(const GuardedArm& arm, const JointPath& path, const GuardedState& state);
  void stop() { active_ = false; }
  /// Whether there is path left; at the end, the attractors of the law take over.
  bool active() const { return active_; }

  /// The joint velocity, per step, for the next step. Inactive afterwards when the rest of the path is short, when the
  /// arm is far from the path, or when the path takes too long. Requires active().
  std::array<double, kMaxJoints> next_velocity(const GuardedArm& arm, const GuardedState& state);

 private:
  static constexpr size_t kSegments = JointPath::kSegments;
  using Joints = std::array<double, kMaxJoints>;

  /// The configuration at `distance` from the start, on a quadratic B-spline with the knots as control points. The
  /// spline is smooth, and lies between the knots, so inside the joint limits.
  void at(double distance, int joints, Joints& theta) const;

  JointPath path_;
  std::array<double, kSegments + 1> distance_{};  // of the knots from the start, along the lines between them
  double covered_ = 0, speed_ = 0;
  int steps_ = 0;
  bool active_ = false;
};

}  // namespace multireach::controller
