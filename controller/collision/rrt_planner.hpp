#pragma once

#include <array>
#include <span>
#include <vector>

#include "controller/collision/proximity.hpp"

namespace multireach::controller {

/// The joint configurations of a path, at most kCapacity; allocates no memory.
class Path {
 public:
  static constexpr size_t kCapacity = 64;

  bool empty() const { return size_ == 0; }
  size_t size() const { return size_; }
  const JointVector& operator[](size_t k) const { return points_[k]; }
  const JointVector& back() const { return points_[size_ - 1]; }
  void clear() { size_ = 0; }
  /// Requires size() < kCapacity.
  void push_back(const JointVector& theta) { points_[size_++] = theta; }

 private:
  std::array<JointVector, kCapacity> points_;
  size_t size_ = 0;
};

/// Plans a collision-free path in joint space: RRT-Connect (Kuffner & LaValle, ICRA 2000) with seeded samples, then
/// shortened. Allocates all memory at construction.
class RrtPlanner {
 public:
  /// `fixed`: joints that stay where they start.
  explicit RrtPlanner(const Chain& chain, const std::array<bool, kMaxJoints>& fixed = {});
  /// A copy has its own memory and no path.
  RrtPlanner(const RrtPlanner& other) : RrtPlanner(other.chain_, other.fixed_) {}
  RrtPlanner& operator=(const RrtPlanner&) = default;

  /// Joint configurations from `start` (not included) to `goal`, joined by straight lines in joint space. The clearance
  /// along the lines is not negative; where the start or the goal has less, it is at least the lesser of theirs. Empty
  /// when a bounded number of samples finds no path. Valid until the next call.
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
  std::array<bool, kMaxJoints> fixed_;
  Tree from_start_, from_goal_;
  std::vector<JointVector> path_;
  double least_clearance_ = 0;
};

}  // namespace multireach::controller
