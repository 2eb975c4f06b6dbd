#include "controller/law/reach_path.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::controller {
namespace {

/// Share of the reach: a target that is nearer than this needs no path, and one that moves further than this from where
/// it was needs another.
constexpr double kNear = 0.05, kMoved = 0.02;
/// Steps (StepPace) from the target to the beginning of the path.
constexpr int kDelay = 7;
/// Steps (StepPace) for which the present velocity of the target counts when a plan begins: about a reach.
constexpr int kReachSteps = 140;
/// Steps of the rehearsal for each step of the arm.
constexpr int kRehearsalSteps = 40;
/// A path must be shorter than this share of the law's own way.
constexpr double kShorter = 0.99;

}  // namespace

ReachPath::ReachPath(const Chain& chain, const GuardedSettings& settings, const LevenbergMarquardtIk& solver, int work)
    : planner_(chain, settings.mobility, solver), work_(work), delay_(settings.pace.steps(kDelay)) {}

void ReachPath::stop() {
  until_path_ = 0;
  leads_ = led_ = false;
  follower_.stop();
}

bool ReachPath::target_moved(const GuardedArm& arm, const TaskTarget& target) const {
  return !((target.position - target_.position).norm() <= kMoved * arm.settings.reach);
}

void ReachPath::rehearse(const GuardedArm& arm, int steps) {
  for (int k = 0; k < steps && !rehearsal_arrived_; ++k) {
    guarded_step(arm, target_, {}, rehearsed_);
    const std::array<double, 3> x = rehearsed_.position(0);
    double moved = 0, left = 0;
    for (size_t m = 0; m < 3; ++m) {
      moved += (x[m] - rehearsed_position_[m]) * (x[m] - rehearsed_position_[m]);
      left += (x[m] - target_.position[static_cast<Eigen::Index>(m)]) *
              (x[m] - target_.position[static_cast<Eigen::Index>(m)]);
    }
    rehearsed_length_ += std::sqrt(moved);
    rehearsed_position_ = x;
    rehearsal_arrived_ = std::sqrt(left) < GuardedTuning::kAtTarget * arm.settings.reach;
  }
}

void ReachPath::begin(const GuardedArm& arm, const GuardedState& state, const TaskTarget& target) {
  stop();
  target_ = target;
  if (target.task != TaskKind::kPosition ||
      target.velocity.norm() * arm.settings.pace.steps(kReachSteps) > kMoved * arm.settings.reach)
    return;
  target_.velocity.setZero();
  const std::array<double, 3> x = state.position(0);
  const Eigen::Vector3d hand(x[0], x[1], x[2]);
  if ((hand - target.position).norm() < kNear * arm.settings.reach) return;
  rehearsed_ = state;
  rehearsed_.disturbance.fill(0);
  rehearsal_arrived_ = false;
  rehearse(arm, delay_);
  if (rehearsal_arrived_) return;
  rehearsed_length_ = 0;
  rehearsed_position_ = rehearsed_.position(0);
  const int n = arm.links.size;
  JointVector start(n), theta_target(n);
  for (int i = 0; i < n; ++i) {
    const bool inside = rehearsed_.theta[i] >= arm.settings.lower[i] && rehearsed_.theta[i] <= arm.settings.upper[i];
    if (!inside) return;
    start[i] = rehearsed_.theta[i];
    theta_target[i] = rehearsed_.theta_target[i];
  }
  planner_.begin(start, target.position, theta_target);
  until_path_ = delay_ + 1;
}

bool ReachPath::take_over(const GuardedArm& arm, GuardedState& state) {
  if (!planner_.found()) return false;
  if (rehearsal_arrived_ && planner_.length_m() > kShorter * rehearsed_length_) return false;
  const int n = arm.links.size;
  JointPath path = planner_.path();
  for (int i = 0; i < n; ++i) {
    path.knots[0][i] = state.theta[i];
    state.theta_target[i] = path.knots[JointPath::kSegments][i];
  }
  update_kinematics(arm, state);
  follower_.begin(arm, path, state);
  return follower_.active();
}

void ReachPath::before_step(const GuardedArm& arm, const TaskTarget& target, Proximity& proximity,
                            GuardedState& state) {
  led_ = false;
  if (until_path_ == 0 && !leads_) return;
  const bool disturbed = std::ranges::any_of(state.disturbance, [](double d) { return d != 0; });
  if (disturbed || target_moved(arm, target)) {
    until_path_ = 0;
    follower_.stop();
    return;
  }
  if (!leads_) {
    --until_path_;
    if (until_path_ > 0) {
      const int slices = delay_ + 1 - until_path_;  // the work of the first `slices` of delay_ steps is due
      const auto due = [this](int64_t parts) { return static_cast<int>(work_ * parts / delay_); };
      planner_.advance(due(slices) - due(slices - 1), proximity);
      rehearse(arm, kRehearsalSteps);
      return;
    }
    leads_ = take_over(arm, state);
    if (!leads_) return;
  }
  // The joints' attractor, v + alpha (beta (theta_T - theta) - v + disturbance), then gives the velocity of the path.
  const auto [alpha, beta] = arm.settings.gains;
  const auto velocity = follower_.next_velocity(arm, state);
  for (int i = 0; i < arm.links.size; ++i) {
    const double before = state.velocity[i], apart = state.theta_target[i] - state.theta[i];
    state.disturbance[i] = (velocity[i] - before) / alpha + before - beta * apart;
  }
  state.gamma = 0;
  state.target_fixed = true;
  led_ = true;
}

bool ReachPath::after_step(GuardedState& state) {
  if (led_) state.disturbance.fill(0);
  if (!leads_ || follower_.active()) return false;
  leads_ = false;
  return true;
}

}  // namespace multireach::controller
