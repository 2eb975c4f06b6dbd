#include "controller/ik/multi_start.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "numeric/random.hpp"

namespace multireach::controller {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
/// A target further away than this many reaches is moved to that distance. Only its direction matters, and huge numbers
/// then do no harm.
constexpr double kFar = 10;
/// Share of the reach: for an unreachable target, errors that differ by less than this count as equal, and the
/// configuration nearer to the start wins.
constexpr double kAsGood = 1e-3;
/// A joint is heavy when it weighs this many times as much as the lightest.
constexpr double kHeavy = 4;
/// How many solutions, the nearest first, are moved along their self-motion towards the given configuration.
constexpr int kDrawn = 3;

}  // namespace

MultiStartIk::MultiStartIk(const Chain& chain, const IkOptions& options, const Tool& tool)
    : chain_(chain), options_(options), solver_(chain, tool, options.joint_weights) {
  const JointVector& weights = options.joint_weights;
  if (weights.size() == 0 || (weights.array() == weights[0]).all()) {
    closed_form_ik_ = ClosedFormIk::from(chain, options.samples);  // it knows no weights
    return;
  }
  JointVector light = weights;
  bool some_heavy = false;
  for (int i = 0; i < chain.size(); ++i) {
    locked_[i] = !std::isfinite(weights[i]);
    heavy_[i] = weights[i] >= kHeavy * weights.minCoeff();
    if (!heavy_[i]) continue;
    some_heavy = some_heavy || !locked_[i];
    light[i] = std::numeric_limits<double>::infinity();
  }
  if (some_heavy) light_solver_.emplace(chain, tool, light);
}

void MultiStartIk::draw(const CounterRandom& random, uint64_t& counter, const JointSet& fixed,
                        JointVector& posture) const {
  for (int i = 0; i < chain_.size(); ++i) {
    const double drawn = random.uniform(counter++, chain_.sample_lower(i), chain_.sample_upper(i));
    if (!fixed[i]) posture[i] = drawn;
  }
}

std::optional<JointVector> MultiStartIk::nearest(const Eigen::Vector3d& x_T, const JointVector& theta) const {
  if (!x_T.allFinite() || !theta.allFinite()) return std::nullopt;
  const IkSolution found = best({.position = x_T}, theta);
  if (found.error_m > options_.tolerance_m) return std::nullopt;
  return found.theta;
}

TaskTarget within_ten_reaches(const Chain& chain, TaskTarget target) {
  const Eigen::Vector3d shoulder = chain.fixed(0).translation(), from_shoulder = target.position - shoulder;
  const double distance = from_shoulder.stableNorm(), far = kFar * chain.reach();
  if (distance > far) {
    target.position = shoulder + from_shoulder.stableNormalized() * far;
    target.velocity.setZero();
  }
  const double speed = target.velocity.stableNorm();
  if (speed > chain.reach()) target.velocity = target.velocity.stableNormalized() * chain.reach();
  return target;
}

IkSolution MultiStartIk::best(const TaskTarget& target, const JointVector& theta) const {
  const TaskTarget near = within_ten_reaches(chain_, target);
  if (closed_form_ik_ && target.task == TaskKind::kPosition) {
    // All solutions inside the limits may lie between two samples; then multi_start() below continues.
    if (auto posture = closed_form_ik_->nearest(near.position, theta)) {
      return {*posture, solver_.error(near, *posture)};
    }
  }
  const JointVector from = solver_.clamped(theta);
  if (light_solver_) {
    const IkSolution light = multi_start(*light_solver_, heavy_, options_.starts, near, from);
    if (light.error_m <= options_.tolerance_m) return light;
  }
  return multi_start(solver_, locked_, options_.most_starts, near, theta);
}

IkSolution MultiStartIk::first(const TaskTarget& target, const JointVector& theta) const {
  const TaskTarget near = within_ten_reaches(chain_, target);
  const CounterRandom random(options_.seed);
  IkSolution best{solver_.clamped(theta), std::numeric_limits<double>::infinity()};
  JointVector posture = best.theta;
  uint64_t counter = 0;
  for (int start = 0; start <= options_.most_starts; ++start) {
    if (start > 0) draw(random, counter, locked_, posture);
    const double error = solver_.solve(near, posture, options_.tolerance_m);
    if (error < best.error_m) best = {posture, error};
    if (error <= options_.tolerance_m) break;
  }
  return best;
}

IkSolution MultiStartIk::multi_start(const LevenbergMarquardtIk& solver, const JointSet& fixed, int most_starts,
                                     const TaskTarget& target, const JointVector& theta) const {
  const CounterRandom random(options_.seed);
  struct Candidate {
    JointVector posture;
    double distance = std::numeric_limits<double>::infinity();
  };
  std::array<Candidate, kDrawn> nearest;  // sorted by distance
  IkSolution best{solver_.clamped(theta), std::numeric_limits<double>::infinity()};
  uint64_t counter = 0;
  int solutions = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int start = 0; start <= most_starts; ++start) {
    if (solutions >= options_.solutions || (solutions > 0 && start > options_.starts)) break;
    JointVector posture = solver_.clamped(theta);
    if (start > 0) draw(random, counter, fixed, posture);
    const double error = solver.solve(target, posture, options_.tolerance_m);
    for (int i = 0; i < chain_.size(); ++i) {
      if (!chain_.joint(i).limited() && !fixed[i]) posture[i] -= kTurn * std::round((posture[i] - theta[i]) / kTurn);
    }
    // Of two configurations with nearly the same error, e.g. two stretched ones, prefer the one nearer to theta.
    const double slack = kAsGood * chain_.reach();
    if (error < least - slack ||
        (error < least + slack && solver_.distance(posture, theta) < solver_.distance(best.theta, theta))) {
      best = {posture, error};
    }
    least = std::min(least, error);
    if (error > options_.tolerance_m) continue;
    ++solutions;
    Candidate candidate{posture, solver_.distance(posture, theta)};
    for (Candidate& kept : nearest) {
      if (candidate.distance < kept.distance) std::swap(candidate, kept);
    }
  }
  if (solutions == 0) return best;
  double distance = std::numeric_limits<double>::infinity();
  for (Candidate& candidate : nearest) {
    if (!std::isfinite(candidate.distance)) continue;
    solver.approach(target, theta, candidate.posture, options_.tolerance_m);
    const double drawn = solver_.distance(candidate.posture, theta);
    if (drawn >= distance) continue;
    distance = drawn;
    best = {candidate.posture, solver_.error(target, candidate.posture)};
  }
  return best;
}

}  // namespace multireach::controller
