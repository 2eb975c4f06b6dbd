#include "studies/straightness/roadmap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>

#include "numeric/random.hpp"

namespace multireach {
namespace {

constexpr size_t kNeighbours = 12, kStartNeighbours = 30;
constexpr uint64_t kStream = 31;
constexpr double kSampleEvery = 0.15;  // rad (m): samples of the hand's position along a line
constexpr double kJointCost = 2e-3;    // of the reach, for each rad (m) of the joints' motion

}  // namespace

Roadmap::Roadmap(const Chain& chain, int nodes, uint64_t seed) : chain_(chain) {
  for (int k = 0; k < nodes; ++k) {
    const CounterRandom random(seed, kStream + static_cast<uint64_t>(k));
    JointVector theta(chain.size());
    for (int i = 0; i < chain.size(); ++i) {
      theta[i] = random.uniform(static_cast<uint64_t>(i), chain.sample_lower(i), chain.sample_upper(i));
    }
    nodes_.push_back(theta);
    hands_.push_back(chain.position(theta));
  }
  edges_.resize(nodes_.size());
  for (size_t k = 0; k < nodes_.size(); ++k) {
    for (const size_t other : nearest(nodes_[k], kNeighbours + 1)) {
      if (other == k) continue;
      const double one = cost(nodes_[k], nodes_[other]);
      edges_[k].push_back({other, one});
      edges_[other].push_back({k, one});
    }
  }
}

double Roadmap::cost(const JointVector& from, const JointVector& to) const {
  const double joints = (to - from).norm();
  const int samples = std::max(1, static_cast<int>(std::ceil(joints / kSampleEvery)));
  Eigen::Vector3d before = chain_.position(from);
  double sum = kJointCost * chain_.reach() * joints;
  for (int k = 1; k <= samples; ++k) {
    const Eigen::Vector3d x = chain_.position(from + static_cast<double>(k) / samples * (to - from));
    sum += (x - before).norm();
    before = x;
  }
  return sum;
}

std::vector<size_t> Roadmap::nearest(const JointVector& theta, size_t count) const {
  std::vector<std::pair<double, size_t>> all(nodes_.size());
  for (size_t k = 0; k < nodes_.size(); ++k) all[k] = {(nodes_[k] - theta).squaredNorm(), k};
  count = std::min(count, all.size());
  std::ranges::partial_sort(all, all.begin() + static_cast<ptrdiff_t>(count));
  std::vector<size_t> found;
  for (size_t k = 0; k < count; ++k) found.push_back(all[k].second);
  return found;
}

std::vector<JointVector> Roadmap::nodes_near(const Eigen::Vector3d& target, size_t count) const {
  std::vector<std::pair<double, size_t>> all(nodes_.size());
  for (size_t k = 0; k < nodes_.size(); ++k) all[k] = {(hands_[k] - target).squaredNorm(), k};
  count = std::min(count, all.size());
  std::ranges::partial_sort(all, all.begin() + static_cast<ptrdiff_t>(count));
  std::vector<JointVector> found;
  for (size_t k = 0; k < count; ++k) found.push_back(nodes_[all[k].second]);
  return found;
}

std::vector<std::vector<JointVector>> Roadmap::paths(const JointVector& start,
                                                     const std::vector<JointVector>& goals) const {
  // Dijkstra's algorithm over the nodes, from the start; then every goal is joined to its nearest nodes and the start.
  constexpr double kFar = std::numeric_limits<double>::infinity();
  constexpr size_t kStart = std::numeric_limits<size_t>::max();
  std::vector<double> least(nodes_.size(), kFar);
  std::vector<size_t> before(nodes_.size(), kStart);
  using Open = std::pair<double, size_t>;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  for (const size_t k : nearest(start, kStartNeighbours)) {
    least[k] = cost(start, nodes_[k]);
    open.emplace(least[k], k);
  }
  while (!open.empty()) {
    const auto [so_far, k] = open.top();
    open.pop();
    if (so_far > least[k]) continue;
    for (const Edge& edge : edges_[k]) {
      if (so_far + edge.cost >= least[edge.to]) continue;
      least[edge.to] = so_far + edge.cost;
      before[edge.to] = k;
      open.emplace(least[edge.to], edge.to);
    }
  }
  std::vector<std::pair<double, std::vector<JointVector>>> found;
  for (const JointVector& goal : goals) {
    double best = cost(start, goal);
    size_t last = kStart;
    for (const size_t k : nearest(goal, kStartNeighbours)) {
      const double sum = least[k] + cost(nodes_[k], goal);
      if (sum < best) {
        best = sum;
        last = k;
      }
    }
    std::vector<JointVector> path{goal};
    for (; last != kStart; last = before[last]) path.push_back(nodes_[last]);
    path.push_back(start);
    std::ranges::reverse(path);
    found.emplace_back(best, path);
  }
  std::ranges::stable_sort(found, {}, [](const auto& one) { return one.first; });
  std::vector<std::vector<JointVector>> result;
  for (auto& one : found) result.push_back(std::move(one.second));
  return result;
}

}  // namespace multireach
