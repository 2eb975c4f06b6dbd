#include "studies/straightness/shortest_path.hpp"

#include <algorithm>
#include <cmath>

#include "controller/law/guarded_law.hpp"
#include "controller/law/guarded_settings.hpp"
#include "numeric/random.hpp"

namespace multireach {
namespace {

using controller::JointPath;

constexpr size_t kGoalsOfNodes = 12;  // IK solutions searched from the roadmap's nodes near the target
constexpr size_t kGoalsAtRandom = 12;
constexpr size_t kPaths = 4;  // the cheapest paths, which are optimised
/// gamma * reach^2 of the passes of the optimisation, and its steps in each.
constexpr std::array<double, 3> kGamma = {42.5, 425, 4250};
constexpr int kSteps = 60;
constexpr int kSamples = 16;  // of the hand's position between two knots
constexpr double kTolerance = 1e-7;

}  // namespace

ShortestPath::ShortestPath(const Chain& chain, const Roadmap& roadmap)
    : chain_(chain),
      roadmap_(roadmap),
      solver_(chain, {}),
      optimizer_(chain, controller::guarded_settings(chain, {}).mobility) {}

std::vector<JointVector> ShortestPath::goals(const ReachSample& sample) const {
  std::vector<JointVector> from = roadmap_.nodes_near(sample.target, kGoalsOfNodes);
  for (size_t k = 0; k < kGoalsAtRandom; ++k) {
    const CounterRandom random(k);
    JointVector theta(chain_.size());
    for (int i = 0; i < chain_.size(); ++i) {
      theta[i] = random.uniform(static_cast<uint64_t>(i), chain_.sample_lower(i), chain_.sample_upper(i));
    }
    from.push_back(theta);
  }
  std::vector<JointVector> found{sample.target_posture};
  for (JointVector theta : from) {
    if (solver_.solve({.position = sample.target}, theta, kTolerance) <= kTolerance) found.push_back(theta);
  }
  return found;
}

JointPath ShortestPath::resampled(const std::vector<JointVector>& path) const {
  std::vector<double> at{0};
  for (size_t k = 1; k < path.size(); ++k) at.push_back(at.back() + (path[k] - path[k - 1]).norm());
  JointPath result;
  size_t piece = 1;
  for (size_t k = 0; k <= JointPath::kSegments; ++k) {
    const double wanted = at.back() * static_cast<double>(k) / JointPath::kSegments;
    while (piece + 1 < path.size() && at[piece] < wanted) ++piece;
    const double gap = at[piece] - at[piece - 1];
    const double share = gap > 0 ? std::clamp((wanted - at[piece - 1]) / gap, 0.0, 1.0) : 1;
    result.set_knot(k, path[piece - 1] + share * (path[piece] - path[piece - 1]));
  }
  return result;
}

std::optional<double> ShortestPath::measured(JointPath path, const Eigen::Vector3d& target) const {
  const int n = chain_.size();
  JointVector end = path.knot(JointPath::kSegments, n);
  if (solver_.solve({.position = target}, end, kTolerance) > kTolerance) return std::nullopt;
  path.set_knot(JointPath::kSegments, end);
  Eigen::Vector3d before = chain_.position(path.knot(0, n));
  double length = 0;
  for (size_t k = 0; k < JointPath::kSegments; ++k) {
    const JointVector from = path.knot(k, n), to = path.knot(k + 1, n);
    if (chain_.limit_excess(to) > 0) return std::nullopt;
    for (int sample = 1; sample <= kSamples; ++sample) {
      const Eigen::Vector3d x = chain_.position(from + static_cast<double>(sample) / kSamples * (to - from));
      length += (x - before).norm();
      before = x;
    }
  }
  return length;
}

std::optional<double> ShortestPath::length_m(const ReachSample& sample) {
  const auto paths = roadmap_.paths(sample.start, goals(sample));
  std::optional<double> best;
  for (size_t k = 0; k < std::min(kPaths, paths.size()); ++k) {
    JointPath path = resampled(paths[k]);
    for (const double gamma : kGamma) {
      optimizer_.begin(path, sample.target, gamma / (chain_.reach() * chain_.reach()), 0);
      for (int step = 0; step < kSteps && optimizer_.improve(); ++step) {
      }
      path = optimizer_.path();
      const auto length = measured(path, sample.target);
      if (length && (!best || *length < *best)) best = length;
    }
  }
  return best;
}

}  // namespace multireach
