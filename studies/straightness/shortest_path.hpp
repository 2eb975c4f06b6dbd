#pragma once

#include <optional>

#include "controller/ik/multi_start.hpp"
#include "controller/path/path_optimizer.hpp"
#include "studies/straightness/roadmap.hpp"
#include "studies/study/reach_sample.hpp"

namespace multireach {

/// Searches the joint path inside the limits whose hand path to a target is the shortest: the best paths of a roadmap
/// to many IK solutions of the target, then local optimisation. What it finds is an upper bound of the optimum: the
/// length of a path that exists. There is no time, speed or acceleration in it.
class ShortestPath {
 public:
  /// `roadmap` must outlive this object.
  ShortestPath(const Chain& chain, const Roadmap& roadmap);

  /// Length of the hand's path, m; nullopt when none was found.
  std::optional<double> length_m(const ReachSample& sample);

 private:
  std::vector<JointVector> goals(const ReachSample& sample) const;
  /// The length of a path that is valid: inside the limits, and its end at the target.
  std::optional<double> measured(controller::JointPath path, const Eigen::Vector3d& target) const;
  controller::JointPath resampled(const std::vector<JointVector>& path) const;

  Chain chain_;
  const Roadmap& roadmap_;
  controller::LevenbergMarquardtIk solver_;
  controller::PathOptimizer optimizer_;
};

}  // namespace multireach
