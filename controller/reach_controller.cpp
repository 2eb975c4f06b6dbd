#include "controller/reach_controller.hpp"

#include <cmath>
#include <stdexcept>

#include "controller/coherence.hpp"

namespace multireach::controller {
namespace {

/// A target for which no posture was found is tried again when it has moved this far, m.
constexpr double kTryAgain = 1e-3;

void require(bool sensible, const char* sentence) {
  if (!sensible) throw std::invalid_argument(sentence);
}

}  // namespace

ReachController::ReachController(const Chain& chain, const ReachOptions& options)
    : chain_(chain), options_(options), search_(chain, options.posture_search), rest_(options.rest) {
  require(options.tick_us > 0, "tick_us must be positive");
  require(options.steps_per_tick > 0, "steps_per_tick must be positive");
  require(std::isfinite(options.law.gamma) && options.law.gamma >= 0, "gamma must be a finite number, not negative");
  const ViteGains& gains = options.law.gains;
  require(gains.alpha > 0 && gains.alpha <= 1 && gains.beta > 0 && gains.beta <= 1, "alpha and beta must be in (0, 1]");
  require(options.jump_m > 0 && options.drift_m > 0, "jump_m and drift_m must be positive");
  require(options.lost_after_us >= 0, "lost_after_us must not be negative");
  require(options.posture_search.samples >= 3 && options.posture_search.starts >= 0,
          "the posture search needs at least 3 samples");
  if (rest_.size() == 0) return;
  const auto fault = posture_fault(chain, {rest_.begin(), rest_.end()}, "the rest posture");
  if (fault) throw std::invalid_argument(*fault);
}

bool ReachController::start(const JointVector& theta) {
  if (theta.size() != chain_.size() || !theta.allFinite()) return false;
  state_ = paper_state_at_rest(chain_, theta, theta);
  if (options_.rest.size() == 0) rest_ = chain_.clamped(theta);
  goal_.reset();
  started_ = true;
  return true;
}

bool ReachController::observe(const TargetObservation& observation) {
  if (observation.seen && !(observation.position.allFinite() && observation.velocity.allFinite())) return false;
  if (newest_ && observation.utime < newest_->utime) return false;
  newest_ = observation;
  if (observation.seen) sighting_ = observation;
  return true;
}

void ReachController::restart_grid(int64_t utime) {
  grid_origin_ = utime;
  tick_ = 0;
  if (newest_ && newest_->utime > utime) newest_.reset();
  if (sighting_ && sighting_->utime > utime) sighting_.reset();
}

std::optional<int64_t> ReachController::next_tick() const {
  if (!grid_origin_) return std::nullopt;
  return *grid_origin_ + tick_ * options_.tick_us;
}

bool ReachController::choose_posture(const Eigen::Vector3d& x_T) {
  const auto posture = search_.nearest(x_T, state_.theta);
  ++posture_choices_;
  if (posture) state_.theta_target = *posture;
  return posture.has_value();
}

void ReachController::fall_back() {
  const bool rest = options_.without_target == WithoutTarget::kGoToRest;
  if (rest && !(goal_ && goal_->mode == ReachMode::kResting)) {
    goal_ = Goal{chain_.position(rest_), Eigen::Vector3d::Zero(), ReachMode::kResting};
    state_.theta_target = rest_;
  } else if (!rest && goal_) {
    goal_->mode = ReachMode::kHolding;
    goal_->velocity.setZero();
  }
}

void ReachController::pursue(const TargetObservation& target) {
  const bool followed =
      goal_ && goal_->mode != ReachMode::kResting && (target.position - goal_->x_T).norm() <= options_.jump_m;
  const bool tried = unreachable_ && (target.position - *unreachable_).norm() < kTryAgain;
  if (tried || (!followed && !choose_posture(target.position))) {
    if (!tried) unreachable_ = target.position;
    out_of_reach_ = true;
    fall_back();
    return;
  }
  unreachable_.reset();
  const double steps_per_second = 1e6 * options_.steps_per_tick / static_cast<double>(options_.tick_us);
  goal_ = Goal{target.position, target.velocity / steps_per_second, ReachMode::kReaching};
}

void ReachController::choose_goal(int64_t now) {
  lost_ = !sighting_ || now - sighting_->utime > options_.lost_after_us;
  out_of_reach_ = false;
  if (lost_) {
    if (sighting_) fall_back();
  } else {
    pursue(*sighting_);
  }
}

void ReachController::step() {
  const JointVector previous_target = state_.theta_target;
  paper_step(chain_, options_.law, goal_->x_T, goal_->velocity, state_);
  if (goal_->mode == ReachMode::kResting) {
    state_.theta_target = rest_;
    return;
  }
  // Eq. (27) knows no limits and no singularities. Written so that a theta_T that is not finite counts as drifted.
  const bool near = (goal_->x_T - chain_.position(state_.theta_target)).norm() <= options_.drift_m;
  if ((near && chain_.limit_excess(state_.theta_target) <= 0) || choose_posture(goal_->x_T)) return;
  // The target went out of reach while it was being followed: keep the last posture that made sense.
  state_.theta_target = previous_target;
  unreachable_ = goal_->x_T;
  goal_->x_T = chain_.position(previous_target);
  out_of_reach_ = true;
  fall_back();
}

ReachOutput ReachController::tick() {
  ReachOutput output;
  output.utime = *next_tick();
  output.tick = tick_++;
  choose_goal(output.utime);
  if (goal_) {
    for (int k = 0; k < options_.steps_per_tick; ++k) step();
  }
  output.mode = goal_ ? goal_->mode : ReachMode::kWaiting;
  output.target_lost = lost_;
  output.target_out_of_reach = out_of_reach_;
  output.theta = state_.theta;
  output.velocity = state_.theta_dot * (1e6 * options_.steps_per_tick / static_cast<double>(options_.tick_us));
  output.theta_target = state_.theta_target;
  output.x = state_.x;
  output.x_T = goal_ ? goal_->x_T : state_.x;
  Eigen::Vector3d x;
  PositionJacobian jacobian;
  chain_.position_and_jacobian(state_.theta, x, jacobian);
  output.weights = limit_weights(chain_, state_.theta, options_.law.gamma);
  output.condition_number = condition_number(coherence_matrix(jacobian, output.weights));
  output.attractor_residual_m = (output.x_T - chain_.position(state_.theta_target)).norm();
  output.posture_choices = posture_choices_;
  return output;
}

}  // namespace multireach::controller
