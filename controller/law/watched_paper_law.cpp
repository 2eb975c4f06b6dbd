#include "controller/law/watched_paper_law.hpp"

#include <cmath>
#include <stdexcept>

namespace multireach::controller {
namespace {

/// A target for which no posture was found is tried again when it has moved this far, m.
constexpr double kTryAgain = 1e-3;

void require(bool sensible, const char* sentence) {
  if (!sensible) throw std::invalid_argument(sentence);
}

}  // namespace

WatchedPaperLaw::WatchedPaperLaw(const Chain& chain, const PaperParameters& parameters, double drift_m,
                                 const PostureSearchOptions& search)
    : chain_(chain), parameters_(parameters), drift_m_(drift_m), search_(chain, search) {
  const ViteGains& gains = parameters.gains;
  require(std::isfinite(parameters.gamma) && parameters.gamma >= 0, "gamma must be a finite number, not negative");
  require(gains.alpha > 0 && gains.alpha <= 1 && gains.beta > 0 && gains.beta <= 1, "alpha and beta must be in (0, 1]");
  require(drift_m > 0, "drift_m must be positive");
  start(chain.clamped(JointVector::Zero(chain.size())));
}

bool WatchedPaperLaw::start(const JointVector& theta) {
  if (theta.size() != chain_.size() || !theta.allFinite() || theta.cwiseAbs().maxCoeff() > 1e5) return false;
  state_ = paper_state_at_rest(chain_, theta, theta);
  target_.reset();
  posture_.reset();
  unreachable_.reset();
  out_of_reach_ = false;
  return true;
}

bool WatchedPaperLaw::choose_posture(const Eigen::Vector3d& x_T) {
  const auto posture = search_.nearest(x_T, state_.theta);
  ++posture_choices_;
  if (posture) state_.theta_target = *posture;
  return posture.has_value();
}

Aimed WatchedPaperLaw::aim(const HandTarget& target) {
  if (!target.position.allFinite() || !target.velocity.allFinite()) return Aimed::kRefused;
  const bool tried = unreachable_ && (target.position - *unreachable_).norm() < kTryAgain;
  if (tried || !choose_posture(target.position)) {
    if (!tried) unreachable_ = target.position;
    out_of_reach_ = true;
    return Aimed::kOutOfReach;
  }
  unreachable_.reset();
  out_of_reach_ = false;
  target_ = target;
  posture_.reset();
  return Aimed::kWithinReach;
}

Aimed WatchedPaperLaw::follow(const HandTarget& target) {
  if (!target.position.allFinite() || !target.velocity.allFinite()) return Aimed::kRefused;
  if (!target_ || posture_ || out_of_reach_) return aim(target);
  target_ = target;
  return Aimed::kWithinReach;
}

bool WatchedPaperLaw::aim_at_posture(const JointVector& theta) {
  if (theta.size() != chain_.size() || !theta.allFinite() || chain_.limit_excess(theta) > 0) return false;
  target_ = HandTarget{.position = chain_.position(theta)};
  posture_ = theta;
  state_.theta_target = theta;
  return true;
}

void WatchedPaperLaw::step() {
  if (!target_) return;
  const JointVector previous = state_.theta_target;
  paper_step(chain_, parameters_, target_->position, target_->velocity, state_);
  if (posture_) {
    state_.theta_target = *posture_;
    return;
  }
  // Eq. (27) knows no limits and no singularities. Written so that a theta_T that is not finite counts as drifted.
  const bool near = (target_->position - chain_.position(state_.theta_target)).norm() <= drift_m_;
  if ((near && chain_.limit_excess(state_.theta_target) <= 0) || choose_posture(target_->position)) return;
  // The target went out of reach while it was being followed: keep the last posture that made sense.
  state_.theta_target = previous;
  unreachable_ = target_->position;
  target_->position = chain_.position(previous);
  target_->velocity.setZero();
  out_of_reach_ = true;
}

JointVector WatchedPaperLaw::weights() const {
  return paper_weights(chain_, parameters_, state_.theta);
}

}  // namespace multireach::controller
