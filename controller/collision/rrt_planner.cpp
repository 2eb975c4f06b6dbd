#include "controller/collision/rrt_planner.hpp"

#include <algorithm>
#include <cmath>

#include "numeric/random.hpp"

namespace multireach::controller {
namespace {

constexpr int kMaxNodes = 500, kMaxSamples = 400;  // some 10 ms; after a failure the caller tries another seed
constexpr double kStep = 0.25;                     // rad (m): length of the longest edge of a tree
constexpr double kResolution = 0.05;               // rad (m): spacing of collision checks along an edge

}  // namespace

RrtPlanner::RrtPlanner(const Chain& chain, const std::array<bool, kMaxJoints>& fixed) : chain_(chain), fixed_(fixed) {
  from_start_.reserve(kMaxNodes);
  from_goal_.reserve(kMaxNodes);
  path_.reserve(2 * kMaxNodes);
}

bool RrtPlanner::clear(const JointVector& theta, Proximity& proximity) const {
  return proximity.clearance(theta) >= least_clearance_;
}

bool RrtPlanner::clear_between(const JointVector& from, const JointVector& to, Proximity& proximity) const {
  const int parts = std::max(1, static_cast<int>(std::ceil((to - from).norm() / kResolution)));
  for (int k = 1; k <= parts; ++k) {
    if (!clear(from + (to - from) * (static_cast<double>(k) / parts), proximity)) return false;
  }
  return true;
}

int RrtPlanner::nearest(const Tree& tree, const JointVector& theta) const {
  const auto found =
      std::ranges::min_element(tree, {}, [&](const Node& node) { return (node.theta - theta).squaredNorm(); });
  return static_cast<int>(found - tree.begin());
}

/// Adds a node one step towards a configuration. Returns its index, or -1 when the edge collides or the tree is full.
int RrtPlanner::extend(Tree& tree, const JointVector& towards, Proximity& proximity) const {
  const int parent = nearest(tree, towards);
  const JointVector from = tree[static_cast<size_t>(parent)].theta, difference = towards - from;
  const double distance = difference.norm();
  const JointVector next = distance > kStep ? JointVector(from + difference * (kStep / distance)) : towards;
  if (tree.size() == kMaxNodes || !clear_between(from, next, proximity)) return -1;
  tree.push_back({next, parent});
  return static_cast<int>(tree.size()) - 1;
}

void RrtPlanner::shorten(Proximity& proximity) {
  // Connect each configuration directly to the furthest later one with a collision-free straight line.
  for (size_t from = 0; from + 2 < path_.size(); ++from) {
    for (size_t to = path_.size() - 1; to > from + 1; --to) {
      if (!clear_between(path_[from], path_[to], proximity)) continue;
      path_.erase(path_.begin() + static_cast<std::ptrdiff_t>(from) + 1,
                  path_.begin() + static_cast<std::ptrdiff_t>(to));
      break;
    }
  }
}

std::span<const JointVector> RrtPlanner::plan(const JointVector& start, const JointVector& goal, Proximity& proximity,
                                              uint64_t seed) {
  path_.clear();
  least_clearance_ = std::min({0.0, proximity.clearance(start), proximity.clearance(goal)}) - 1e-6;
  from_start_.clear();
  from_goal_.clear();
  from_start_.push_back({start, -1});
  from_goal_.push_back({goal, -1});
  const CounterRandom random(seed, 7);
  uint64_t counter = 0;
  JointVector sample(chain_.size());
  for (int k = 0; k < kMaxSamples; ++k) {
    const bool even = k % 2 == 0;
    Tree& grown = even ? from_start_ : from_goal_;
    Tree& other = even ? from_goal_ : from_start_;
    for (int i = 0; i < chain_.size(); ++i) {
      sample[i] = random.uniform(counter++, chain_.sample_lower(i), chain_.sample_upper(i));
      if (fixed_[static_cast<size_t>(i)]) sample[i] = start[i];
    }
    const int reached = k == 0 ? 0 : extend(grown, sample, proximity);
    if (reached < 0) continue;
    const JointVector target = grown[static_cast<size_t>(reached)].theta;
    int met = -1;
    do {
      met = extend(other, target, proximity);
    } while (met >= 0 && other[static_cast<size_t>(met)].theta != target);
    if (met < 0) continue;
    const int in_start = even ? reached : met, in_goal = even ? met : reached;
    for (int node = in_start; node >= 0; node = from_start_[static_cast<size_t>(node)].parent) {
      path_.push_back(from_start_[static_cast<size_t>(node)].theta);
    }
    std::ranges::reverse(path_);
    for (int node = from_goal_[static_cast<size_t>(in_goal)].parent; node >= 0;
         node = from_goal_[static_cast<size_t>(node)].parent) {
      path_.push_back(from_goal_[static_cast<size_t>(node)].theta);
    }
    shorten(proximity);
    return std::span<const JointVector>(path_).subspan(1);
  }
  return {};
}

}  // namespace multireach::controller
