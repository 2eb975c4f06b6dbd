#pragma once

#include <optional>

#include "controller/ik/posture_search_options.hpp"
#include "controller/ik/posture_solver.hpp"
#include "controller/ik/shoulder_elbow.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

/// A posture, and how far its hand is from the target (distance and weighted rotation, m).
struct FoundPosture {
  JointVector theta;
  double error_m = 0;
};

/// A target that is very far from the arm (finite), moved along its direction to ten times the arm's reach; and its
/// velocity, where that is more than one reach per step, made so long.
HandTarget brought_near(const Chain& chain, HandTarget target);

/// Finds, among all postures inside the limits whose hand is at a given target, one nearest to a given posture: the
/// first theta_T of Sect. 3.4. In closed form for the position of a shoulder-elbow arm; by damped Newton steps from
/// seeded starts, each then drawn along its self-motion towards the given posture, for anything else.
class PostureSearch {
 public:
  explicit PostureSearch(const Chain& chain, const PostureSearchOptions& options = {}, const Tool& tool = {});

  /// Nothing when no posture was found: the point is out of reach (or, for an arm without closed form, so hard to reach
  /// that no start led there).
  std::optional<JointVector> nearest(const Eigen::Vector3d& x_T, const JointVector& theta) const;
  /// The same for any target. When no posture meets the target, the one whose hand comes nearest to it, of all those
  /// found. The target and `theta` must be finite.
  FoundPosture best(const HandTarget& target, const JointVector& theta) const;
  /// A posture that meets the target, the first that is found: from `theta` itself, then from the seeded starts. In a
  /// fraction of the time of `best`, but it may be far from `theta`. When none meets the target, the nearest miss.
  FoundPosture first(const HandTarget& target, const JointVector& theta) const;
  /// The same as `nearest` by the closed form alone, which may miss postures between two samples. Nothing without a
  /// closed form.
  std::optional<JointVector> closed_form_nearest(const Eigen::Vector3d& x_T, const JointVector& theta) const {
    if (!shoulder_elbow_) return std::nullopt;
    return shoulder_elbow_->nearest(x_T, theta);
  }
  bool closed_form() const { return shoulder_elbow_.has_value(); }
  /// The closed form itself; only where there is one.
  const ShoulderElbow& shoulder_elbow() const { return *shoulder_elbow_; }
  const PostureSearchOptions& options() const { return options_; }

 private:
  FoundPosture multi_start(const HandTarget& target, const JointVector& theta) const;

  Chain chain_;
  PostureSearchOptions options_;
  PostureSolver solver_;
  std::optional<ShoulderElbow> shoulder_elbow_;
};

}  // namespace multireach::controller
