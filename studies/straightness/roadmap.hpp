#pragma once

#include <cstdint>
#include <vector>

#include "kinematics/chain.hpp"

namespace multireach {

/// Random configurations of an arm inside its limits, each joined to its nearest ones by straight lines in joint space
/// (a probabilistic roadmap; Kavraki et al., IEEE Trans. Robotics and Automation, 1996). The cost of a line is the
/// length of the hand's path along it, with a small part for the joints' motion.
class Roadmap {
 public:
  Roadmap(const Chain& chain, int nodes, uint64_t seed);

  /// The paths of least cost from `start` to each of the `goals`, start and goal included, the cheapest first.
  std::vector<std::vector<JointVector>> paths(const JointVector& start, const std::vector<JointVector>& goals) const;
  /// The nodes whose hand positions are nearest to `target` (m, in W), the nearest first.
  std::vector<JointVector> nodes_near(const Eigen::Vector3d& target, size_t count) const;

 private:
  struct Edge {
    size_t to;
    double cost;
  };

  double cost(const JointVector& from, const JointVector& to) const;
  std::vector<size_t> nearest(const JointVector& theta, size_t count) const;

  Chain chain_;
  std::vector<JointVector> nodes_;
  std::vector<Eigen::Vector3d> hands_;
  std::vector<std::vector<Edge>> edges_;
};

}  // namespace multireach
