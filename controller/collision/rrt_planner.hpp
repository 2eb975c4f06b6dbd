#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "controller/collision/proximity.hpp"
#include "numeric/random.hpp"

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
/// shortened. The work may be divided into parts of any size; the path is the same. Allocates all memory at
/// construction.
class RrtPlanner {
 public:
  static constexpr int kAllWork = std::numeric_limits<int>::max();

  /// `fixed`: joints that stay where they start.
  explicit RrtPlanner(const Chain& chain, const std::array<bool, kMaxJoints>& fixed = {});
  /// A copy has its own memory, and continues the same plan.
  RrtPlanner(const RrtPlanner& other) : RrtPlanner(other.chain_, other.fixed_) { *this = other; }
  RrtPlanner& operator=(const RrtPlanner&) = default;

  /// Begins to plan from `start` to `goal`. Computes two clearances.
  void begin(const JointVector& start, const JointVector& goal, Proximity& proximity, uint64_t seed);
  /// Continues by about `work` units, and returns whether the plan is finished. A unit is the distance between two
  /// shapes, 0.1 to 0.2 us; what else a clearance or a node of a tree needs counts as some more. No clearance is
  /// divided.
  bool continue_planning(Proximity& proximity, int work);
  /// When finished: joint configurations from the start (not included) to the goal, joined by straight lines in joint
  /// space. The clearance along the lines is not negative; where the start or the goal has less, it is at least the
  /// lesser of theirs. Empty when a bounded number of samples finds no path. Valid until begin().
  std::span<const JointVector> path() const;

 private:
  struct Node {
    JointVector theta;
    int parent;
  };
  using Tree = std::vector<Node>;
  /// A straight line in joint space, whose clearance is computed at equal distances.
  struct Line {
    JointVector from, to;
    int next = 1, parts = 1;
  };
  enum class Phase { kSample, kGrow, kConnect, kShorten, kFinished };
  enum class LineCheck { kNotYet, kClear, kCollides };

  Tree& tree(bool of_start) { return of_start ? from_start_ : from_goal_; }
  void begin_line(const JointVector& from, const JointVector& to);
  /// Continues the line's check while there is work, of which it takes what it needs.
  LineCheck check_line(Proximity& proximity, int& work);
  void draw_sample();
  /// Begins the edge from the nearest node of a tree towards a configuration. False when the tree is full.
  bool begin_edge(const Tree& tree, const JointVector& towards, int& work);
  void begin_connecting(const JointVector& target, int& work);
  void join(int in_grown, int in_other);
  void begin_shortening();
  void next_shortcut();

  Chain chain_;
  std::array<bool, kMaxJoints> fixed_;
  Tree from_start_, from_goal_;
  std::vector<JointVector> path_;
  double least_clearance_ = 0;
  Phase phase_ = Phase::kFinished;
  CounterRandom random_{0, 0};
  uint64_t drawn_ = 0;
  int samples_ = 0;           // drawn so far; every second one grows the goal's tree
  bool grows_start_ = false;  // which tree the current sample grows
  int grown_ = 0, parent_ = 0;
  JointVector target_;  // the node that the other tree is to reach
  Line line_;
  size_t shorten_from_ = 0, shorten_to_ = 0;
};

}  // namespace multireach::controller
