#include "controller/law/supervised_paper_law.hpp"

#include <cmath>
#include <stdexcept>

namespace multireach::controller {
namespace {

/// An unreachable target is searched for again when it has moved this far, m.
constexpr double kTryAgain = 1e-3;

void require(bool sensible, const char* sentence) {
  if (!sensible) throw std::invalid_argument(sentence);
}

}  // namespace

SupervisedPaperLaw::SupervisedPaperLaw(const Chain& chain, const PaperParameters& parameters, double drift_m,
                                       const IkOptions& search)
    : chain_(chain), parameters_(parameters), drift_m_(drift_m), search_(chain, search) {
  const ViteGains& gains = parameters.gains;
  require(std::isfinite(parameters.gamma) && parameters.gamma >= 0, "gamma must be a finite number, not negative");
  require(gains.alpha > 0 && gains.alpha <= 1 && gains.beta > 0 && gains.beta <= 1, "alpha and beta must be in (0, 1]");
  require(drift_m > 0, "drift_m must be positive");
  start(chain.clamped(JointVector::Zero(chain.size())));
  started_ = false;
}

bool SupervisedPaperLaw::start(const JointVector& theta) {
  if (theta.size() != chain_.size() || !theta.allFinite() || theta.cwiseAbs().maxCoeff() > 1e5) return false;
  state_ = paper_state_at_rest(chain_, theta, theta);
  started_ = true;
  target_.reset();
  posture_.reset();
  failed_target_.reset();
  unreachable_ = false;
  return true;
}

bool SupervisedPaperLaw::search_theta_target(const Eigen::Vector3d& x_T) {
  const auto posture = search_.nearest(x_T, state_.theta);
  ++ik_searches_;
  if (posture) state_.theta_target = *posture;
  return posture.has_value();
}

TargetResult SupervisedPaperLaw::set_target(const TaskTarget& target) {
  if (!started_) return TargetResult::kNotStarted;
  if (!target.position.allFinite() || !target.velocity.allFinite()) return TargetResult::kRefused;
  const bool tried = failed_target_ && (target.position - *failed_target_).norm() < kTryAgain;
  if (tried || !search_theta_target(target.position)) {
    if (!tried) failed_target_ = target.position;
    unreachable_ = true;
    return TargetResult::kUnreachable;
  }
  failed_target_.reset();
  unreachable_ = false;
  target_ = target;
  posture_.reset();
  return TargetResult::kReachable;
}

TargetResult SupervisedPaperLaw::update_target(const TaskTarget& target) {
  if (!target.position.allFinite() || !target.velocity.allFinite()) return TargetResult::kRefused;
  if (!target_ || posture_ || unreachable_) return set_target(target);
  target_ = target;
  return TargetResult::kReachable;
}

bool SupervisedPaperLaw::set_joint_target(const JointVector& theta) {
  if (!started_) return false;
  if (theta.size() != chain_.size() || !theta.allFinite() || chain_.limit_excess(theta) > 0) return false;
  target_ = TaskTarget{.position = chain_.position(theta)};
  posture_ = theta;
  state_.theta_target = theta;
  return true;
}

void SupervisedPaperLaw::step() {
  if (!target_) return;
  const JointVector previous = state_.theta_target;
  paper_step(chain_, parameters_, target_->position, target_->velocity, state_);
  if (posture_) {
    state_.theta_target = *posture_;
    return;
  }
  // Eq. (27) ignores joint limits and singularities. The comparison is false for a theta_T that is not finite.
  const bool near = (target_->position - chain_.position(state_.theta_target)).norm() <= drift_m_;
  if ((near && chain_.limit_excess(state_.theta_target) <= 0) || search_theta_target(target_->position)) return;
  // The target has become unreachable: keep the last valid theta_T.
  state_.theta_target = previous;
  failed_target_ = target_->position;
  target_->position = chain_.position(previous);
  target_->velocity.setZero();
  unreachable_ = true;
}

JointVector SupervisedPaperLaw::weights() const {
  return paper_weights(chain_, parameters_, state_.theta);
}

}  // namespace multireach::controller
