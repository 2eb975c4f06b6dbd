#pragma once

#include <array>
#include <span>
#include <vector>

#include "controller/collision/proximity.hpp"

namespace multireach::controller {

/// The joint configurations of a path, at most kCapacity; takes no memory of its own.
class Path {
 public:
  static constexpr size_t kCapacity = 64;

  bool empty() const { return size_ == 0; }
  size_t size() const { return size_; }
  const JointVector& operator[](size_t k) const { return points_[k]; }
  const JointVector& back() const { return points_[size_ - 1]; }
  void clear() { size_ = 0; }
  /// There must be room.
  void push_back(const JointVector& theta) { points_[size_++] = theta; }

 private:
  std::array<JointVector, kCapacity> points_;
  size_t size_ = 0;
};

/// Plans a way for the joints around what they would bump into: RRT-Connect (Kuffner & LaValle, ICRA 2000) with seeded
/// samples, then shortened. All memory is taken at construction.
class RrtPlanner {
 public:
  explicit RrtPlanner(const Chain& chain);
  /// A copy has memory of its own, and no plan.
  RrtPlanner(const RrtPlanner& other) : RrtPlanner(other.chain_) {}
  RrtPlanner& operator=(const RrtPlanner&) = default;

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
