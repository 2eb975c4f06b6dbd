#include "controller/ik/posture_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "numeric/random.hpp"

namespace multireach::controller {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
/// A target this many times further away than the arm is long is moved to that distance: its direction is all that
/// matters, and numbers of any size stay harmless.
constexpr double kFar = 10;
/// Of the reach: no posture is worth a longer way for coming this much nearer to a target out of reach.
constexpr double kAsGood = 1e-3;
/// So many of the solutions found, the nearest first, are drawn along their self-motion.
constexpr int kDrawn = 3;

}  // namespace

PostureSearch::PostureSearch(const Chain& chain, const PostureSearchOptions& options, const Tool& tool)
    : chain_(chain),
      options_(options),
      solver_(chain, tool),
      shoulder_elbow_(ShoulderElbow::from(chain, options.samples)) {}

std::optional<JointVector> PostureSearch::nearest(const Eigen::Vector3d& x_T, const JointVector& theta) const {
  if (!x_T.allFinite() || !theta.allFinite()) return std::nullopt;
  const FoundPosture found = best({.position = x_T}, theta);
  if (found.error_m > options_.tolerance_m) return std::nullopt;
  return found.theta;
}

HandTarget brought_near(const Chain& chain, HandTarget target) {
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

FoundPosture PostureSearch::best(const HandTarget& target, const JointVector& theta) const {
  const HandTarget near = brought_near(chain_, target);
  if (shoulder_elbow_ && target.aim == Aim::kPosition) {
    // All postures inside the limits may lie between two samples; then the search below goes on.
    if (auto posture = shoulder_elbow_->nearest(near.position, theta)) {
      return {*posture, solver_.error(near, *posture)};
    }
  }
  return multi_start(near, theta);
}

FoundPosture PostureSearch::first(const HandTarget& target, const JointVector& theta) const {
  const HandTarget near = brought_near(chain_, target);
  const CounterRandom random(options_.seed);
  FoundPosture best{chain_.clamped(theta), std::numeric_limits<double>::infinity()};
  JointVector posture = best.theta;
  uint64_t counter = 0;
  for (int start = 0; start <= options_.most_starts; ++start) {
    if (start > 0) {
      for (int i = 0; i < chain_.size(); ++i) {
        posture[i] = random.uniform(counter++, chain_.sample_lower(i), chain_.sample_upper(i));
      }
    }
    const double error = solver_.solve(near, posture, options_.tolerance_m);
    if (error < best.error_m) best = {posture, error};
    if (error <= options_.tolerance_m) break;
  }
  return best;
}

FoundPosture PostureSearch::multi_start(const HandTarget& target, const JointVector& theta) const {
  const CounterRandom random(options_.seed);
  struct Candidate {
    JointVector posture;
    double distance = std::numeric_limits<double>::infinity();
  };
  std::array<Candidate, kDrawn> nearest;  // in order
  FoundPosture best{chain_.clamped(theta), std::numeric_limits<double>::infinity()};
  uint64_t counter = 0;
  int solutions = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int start = 0; start <= options_.most_starts; ++start) {
    if (solutions >= options_.solutions || (solutions > 0 && start > options_.starts)) break;
    JointVector posture = chain_.clamped(theta);
    if (start > 0) {
      for (int i = 0; i < chain_.size(); ++i) {
        posture[i] = random.uniform(counter++, chain_.sample_lower(i), chain_.sample_upper(i));
      }
    }
    const double error = solver_.solve(target, posture, options_.tolerance_m);
    for (int i = 0; i < chain_.size(); ++i) {
      if (!chain_.joint(i).limited()) posture[i] -= kTurn * std::round((posture[i] - theta[i]) / kTurn);
    }
    // Of two postures that miss by nearly the same, as two ways of stretching do, the nearer one.
    const double slack = kAsGood * chain_.reach();
    if (error < least - slack || (error < least + slack && (posture - theta).norm() < (best.theta - theta).norm())) {
      best = {posture, error};
    }
    least = std::min(least, error);
    if (error > options_.tolerance_m) continue;
    ++solutions;
    Candidate candidate{posture, (posture - theta).norm()};
    for (Candidate& kept : nearest) {
      if (candidate.distance < kept.distance) std::swap(candidate, kept);
    }
  }
  if (solutions == 0) return best;
  double distance = std::numeric_limits<double>::infinity();
  for (Candidate& candidate : nearest) {
    if (!std::isfinite(candidate.distance)) continue;
    solver_.approach(target, theta, candidate.posture, options_.tolerance_m);
    const double drawn = (candidate.posture - theta).norm();
    if (drawn >= distance) continue;
    distance = drawn;
    best = {candidate.posture, solver_.error(target, candidate.posture)};
  }
  return best;
}

}  // namespace multireach::controller
