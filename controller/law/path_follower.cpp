#include "controller/law/path_follower.hpp"

#include <algorithm>
#include <cmath>

#include "controller/qp/velocity_bounds.hpp"

namespace multireach::controller {
namespace {

/// The path ends where this share of it, or this distance, rad (m), remains.
constexpr double kRestShare = 0.01, kRest = 0.01;
/// The path ends when a joint is this far from it, rad (m), or after this number of steps (StepPace).
constexpr double kFarOff = 0.3;
constexpr int kMaxSteps = 1400;
/// How often a step along the path is shortened so that every joint can follow.
constexpr int kRounds = 4;
/// An arm beside the path returns to it as fast as if the path were a joint limit: so it does not overshoot. Per step
/// of StepPace.
constexpr double kReturnRate = 0.2;
constexpr double kShortest = 1e-3;  // share of a step below which the path waits

}  // namespace

void PathFollower::begin(const GuardedArm& arm, const JointPath& path, const GuardedState& state) {
  path_ = path;
  const int n = arm.links.size;
  double along = 0;
  for (size_t k = 1; k <= kSegments; ++k) {
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const double moved = path.knots[k][i] - path.knots[k - 1][i];
      sum += moved * moved;
      if (k == 1) along += state.velocity[i] * moved;
    }
    distance_[k] = distance_[k - 1] + std::sqrt(sum);
  }
  covered_ = 0;
  speed_ = distance_[1] > 0 ? std::max(0.0, along / distance_[1]) : 0;
  steps_ = 0;
  active_ = distance_[kSegments] > kRest;
}

void PathFollower::at(double distance, int joints, Joints& theta) const {
  size_t k = 0;
  while (k + 1 < kSegments && distance_[k + 1] < distance) ++k;
  const double gap = distance_[k + 1] - distance_[k];
  const double share = gap > 0 ? std::clamp((distance - distance_[k]) / gap, 0.0, 1.0) : 1;
  // The piece of the spline around the nearer knot. Beyond both ends, a mirrored knot makes it linear.
  const size_t middle = share < 0.5 ? k : k + 1;
  const double t = share < 0.5 ? share + 0.5 : share - 0.5;
  const double before = 0.5 * (1 - t) * (1 - t), after = 0.5 * t * t;
  for (int i = 0; i < joints; ++i) {
    const double here = path_.knots[middle][i];
    const double next = middle < kSegments ? path_.knots[middle + 1][i] : 2 * here - path_.knots[middle - 1][i];
    const double last = middle > 0 ? path_.knots[middle - 1][i] : 2 * here - next;
    theta[i] = before * last + (1 - before - after) * here + after * next;
  }
}

std::array<double, kMaxJoints> PathFollower::next_velocity(const GuardedArm& arm, const GuardedState& state) {
  const GuardedSettings& settings = arm.settings;
  const auto [alpha, beta] = settings.gains;
  const int n = arm.links.size;
  const double length = distance_[kSegments];
  Joints here, ahead, back, velocity{}, lower, upper;
  at(covered_, n, here);
  const double returned = settings.pace.remaining(kReturnRate / (1 + kReturnRate));
  const BarrierRate return_rate(settings.pace.ratio == 1 ? kReturnRate : returned / (1 - returned));
  for (int i = 0; i < n; ++i) {
    const auto bounds = velocity_bounds(state.theta[i], state.velocity[i], settings.lower[i], settings.upper[i],
                                        settings.speed[i], settings.acceleration[i], settings.barrier_rate);
    lower[i] = bounds.lower;
    upper[i] = bounds.upper;
    const double apart = here[i] - state.theta[i];
    if (std::abs(apart) > kFarOff) active_ = false;
    back[i] = barrier(apart, return_rate, settings.acceleration[i]);
  }
  double step = speed_ + alpha * (beta * (length - covered_) - speed_);
  for (int round = 0;; ++round) {
    at(covered_ + step, n, ahead);
    double share = 1;
    for (int i = 0; i < n; ++i) {
      const double moved = ahead[i] - here[i];
      velocity[i] = moved + back[i];
      if (moved > 0 && velocity[i] > upper[i]) share = std::min(share, std::max(0.0, (upper[i] - back[i]) / moved));
      if (moved < 0 && velocity[i] < lower[i]) share = std::min(share, std::max(0.0, (lower[i] - back[i]) / moved));
    }
    if (share == 1 || step == 0 || round == kRounds) break;
    step = share < kShortest ? 0 : step * share;
  }
  speed_ = step;
  covered_ += step;
  const double rest = length - covered_;
  if (rest <= std::max(kRest, kRestShare * length) || ++steps_ > settings.pace.steps(kMaxSteps)) active_ = false;
  return velocity;
}

}  // namespace multireach::controller
