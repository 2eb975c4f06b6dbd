#include "studies/figures/law_run.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "controller/law/supervised_paper_law.hpp"

namespace multireach {

using namespace controller;

JointVector hoap2_posture(const Chain& chain, std::initializer_list<double> degrees) {
  if (chain.size() != static_cast<int>(degrees.size())) {
    throw std::invalid_argument("this scene is made for the arm of the Hoap2, which has 4 joints");
  }
  JointVector theta(chain.size());
  int i = 0;
  for (const double angle : degrees) theta[i++] = angle * std::numbers::pi / 180;
  return theta;
}

PaperRun::PaperRun(const Chain& chain, const PaperParameters& parameters, const JointVector& start, double drift_m)
    : chain_(chain),
      parameters_(parameters),
      search_(chain),
      drift_m_(drift_m),
      state_(paper_state_at_rest(chain, start, start)),
      target_(state_.x) {}

void PaperRun::set_target(const Eigen::Vector3d& x_T) {
  const auto found = search_.nearest(x_T, state_.theta);
  if (!found) throw std::invalid_argument("no posture of this arm reaches a target of the scene");
  target_ = x_T;
  state_.theta_target = *found;
  ++ik_searches_;
}

void PaperRun::step() {
  paper_step(chain_, parameters_, target_, Eigen::Vector3d::Zero(), state_);
  if (std::isinf(drift_m_) || (target_ - chain_.position(state_.theta_target)).norm() <= drift_m_) return;
  if (const auto found = search_.nearest(target_, state_.theta)) state_.theta_target = *found;
  ++ik_searches_;
}

void PaperRun::displace(const JointVector& by) {
  state_.theta += by;
  PositionJacobian jacobian;
  chain_.position_and_jacobian(state_.theta, state_.x, jacobian);
  state_.x_dot = jacobian * state_.theta_dot;
}

Moment PaperRun::moment(double time) const {
  Moment moment = moment_of(chain_, time, state_.theta, state_.theta_dot * kStepsPerSecond);
  moment.theta_target = state_.theta_target;
  return moment;
}

JointVector PaperRun::weights() const {
  return paper_weights(chain_, parameters_, state_.theta);
}

GuardedParameters guarded_parameters(const Chain& chain, double gamma) {
  return {.gamma = gamma, .acceleration = JointVector::Constant(chain.size(), 60)};
}

ReachingLawRun::ReachingLawRun(std::unique_ptr<ReachingLaw> law, const JointVector& start) : law_(std::move(law)) {
  law_->start(start);
}

void ReachingLawRun::set_target(const Eigen::Vector3d& x_T) {
  if (law_->set_target({.position = x_T}) != TargetResult::kReachable) {
    throw std::invalid_argument("no posture of this arm reaches a target of the scene");
  }
}

Moment ReachingLawRun::moment(double time) const {
  Moment moment = moment_of(law_->chain(), time, law_->theta(), law_->velocity() * kStepsPerSecond);
  moment.theta_target = law_->theta_target();
  return moment;
}

std::unique_ptr<LawRun> guarded_run(const Chain& chain, double gamma, const JointVector& start) {
  return std::make_unique<ReachingLawRun>(std::make_unique<GuardedLaw>(chain, guarded_parameters(chain, gamma)), start);
}

std::unique_ptr<LawRun> supervised_paper_run(const Chain& chain, const PaperParameters& parameters,
                                             const JointVector& start) {
  return std::make_unique<ReachingLawRun>(std::make_unique<SupervisedPaperLaw>(chain, parameters, 0.01, IkOptions{}),
                                          start);
}

std::unique_ptr<LawRun> law_run(const Chain& chain, bool paper, double gamma, const JointVector& start) {
  if (paper) return supervised_paper_run(chain, {.gains = {}, .gamma = gamma}, start);
  return guarded_run(chain, gamma > 0 ? gamma : 1e-9, start);  // a tiny gamma in place of 0
}

Motion record(LawRun& run, double seconds, double from) {
  const auto steps = static_cast<int>(std::lround(seconds * kStepsPerSecond));
  Motion motion;
  for (int k = 0; k <= steps; ++k) {
    motion.push_back(run.moment(from + k / kStepsPerSecond));
    if (k < steps) run.step();
  }
  return motion;
}

}  // namespace multireach
