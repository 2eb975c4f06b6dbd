#pragma once

#include <span>
#include <vector>

#include "controller/proximity.hpp"

namespace multireach::controller {

/// Plans a way for the joints around what they would bump into: RRT-Connect (Kuffner & LaValle, ICRA 2000) with seeded
/// samples, then shortened. All memory is taken at construction.
class Detour {
 public:
  explicit Detour(const Chain& chain);

  /// Postures from after `start` to `goal` between which the joints can go straight with a positive clearance (or that
  /// of the start or goal, where that is less). Empty when none was found within a bounded number of samples. Valid
  /// until the next call.
  std::span<const JointVector> plan(const JointVector& start, const JointVector& goal, Proximity& proximity,
                                    uint64_t seed);

 private:
  struct Node {
    JointVector theta;
    int parent;
  };
  using Tree = std::vector<Node>;

  bool clear(const JointVector& theta, Proximity& proximity) const;
  bool clear_between(const JointVector& from, const JointVector& to, Proximity& proximity) const;
  int nearest(const Tree& tree, const JointVector& theta) const;
  int extend(Tree& tree, const JointVector& towards, Proximity& proximity) const;
  void shorten(Proximity& proximity);

  Chain chain_;
  Tree from_start_, from_goal_;
  std::vector<JointVector> way_;
  double least_clearance_ = 0;
};

}  // namespace multireach::controller
