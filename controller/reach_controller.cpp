#include "controller/reach_controller.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "controller/law/paper_equations.hpp"
#include "controller/law/supervised_paper_law.hpp"
#include "controller/task/target_check.hpp"

namespace multireach::controller {
namespace {

void require(bool sensible, const char* sentence) {
  if (!sensible) throw std::invalid_argument(sentence);
}

constexpr int64_t kFlickersWithin = 1000000;  // us: a target flickers when three jumps come within this time ...
constexpr int64_t kSteadyAfter = 300000;      // ... until it has not jumped for so long
constexpr int64_t kStillFor = 1000000;        // us: an arm that stands still for longer short of its target is blocked
constexpr double kStill = 0.01;               // rad (m): a joint that moves less stands still
constexpr double kArrived = 0.005;            // m: an end effector nearer than this to the target has arrived
constexpr double kOffsetAfter = 1e7;          // us: time constant with which a lasting deviation is learnt as an offset
constexpr double kMaxOffset = 0.5;            // rad (m): limits the effect of one wrong measurement on the offset
constexpr int64_t kAfterInterception = 200000;  // us: the hand stays so long where it was to meet the target
constexpr int64_t kTicksWithin = 4;             // tick_us: at most so many ticks
constexpr int64_t kMaxTickPeriod = 1'000'000'000;

bool is_plausible_time(int64_t utime) {
  return utime >= -ReachController::kMaxTime && utime <= ReachController::kMaxTime;
}

std::unique_ptr<ReachingLaw> make_law(const Chain& chain, const ReachOptions& options, double steps_per_second) {
  if (const auto* paper = std::get_if<PaperParameters>(&options.law)) {
    require(options.task == TaskKind::kPosition, "law 'paper' supports only task: position");
    return std::make_unique<SupervisedPaperLaw>(chain, *paper, options.drift_m, options.ik);
  }
  GuardedParameters parameters = std::get<GuardedParameters>(options.law);
  parameters.steps_per_second = steps_per_second;
  parameters.ik = options.ik;
  // Each tick updates the target.
  parameters.extrapolation_s = std::max(parameters.extrapolation_s, 2e-6 * static_cast<double>(options.tick_us));
  return std::make_unique<GuardedLaw>(chain, parameters);
}

}  // namespace

ReachController::ReachController(const Chain& chain, const ReachOptions& options)
    : chain_(chain),
      options_(options),
      rest_(options.rest),
      filter_(options.target),
      direction_(options.direction),
      orientation_(options.orientation),
      fall_(options.intercept.value_or(FreeFallFilter::Options{})) {
  require(options.tick_us > 0 && options.tick_us <= kMaxTickPeriod, "tick_us must be positive, and at most 1e9");
  require(options.steps_per_tick > 0, "steps_per_tick must be positive");
  require(options.target.jump_m > 0, "jump_m must be positive");
  require(options.target.wander_m_per_root_s >= 0, "wander_m_per_root_s must not be negative");
  require(options.prediction_us >= 0 && options.prediction_us <= kMaxTickPeriod,
          "prediction_us must not be negative, and at most 1e9");
  require(options.lost_after_us >= 0, "lost_after_us must not be negative");
  require(options.disturbance_threshold >= 0, "disturbance_threshold must not be negative");
  require(options.ik.samples >= 3 && options.ik.starts >= 0,
          "inverse kinematics needs at least 3 samples, and starts must not be negative");
  law_ = make_law(chain, options, steps_per_second());
  if (options.intercept) {
    require(std::holds_alternative<GuardedParameters>(options.law), "intercept needs GuardedParameters");
    require(options.intercept->gravity.allFinite() && options.intercept->gravity.norm() >= 0.1,
            "gravity must be finite, and at least 0.1 m/s^2");
    require(options.intercept->other_acceleration > 0, "other_acceleration must be positive");
    GuardedParameters parameters = std::get<GuardedParameters>(options.law);
    parameters.steps_per_second = steps_per_second();
    parameters.ik = options.ik;
    planner_.emplace(chain_, parameters);
  }
  for (PastCommand& command : commands_) command.theta = JointVector::Zero(chain.size());
  if (rest_.size() == 0) return;
  const auto fault = joint_configuration_fault(chain, {rest_.begin(), rest_.end()}, "the rest posture");
  if (fault) throw std::invalid_argument(*fault);
  rest_ = chain.clamped(rest_);
}

bool ReachController::start(const JointVector& theta) {
  if (!law_->start(theta)) return false;
  if (options_.rest.size() == 0 && !grid_origin_) rest_ = chain_.clamped(theta);  // not where it starts again
  filter_.reset();
  forget_flight();
  last_seen_.reset();
  jumps_.fill(std::nullopt);
  flickers_ = false;
  mode_ = ReachMode::kWaiting;
  dwelling_ = false;
  measured_.reset();
  offset_ = JointVector::Zero(chain_.size());
  commands_recorded_ = 0;
  record_command();
  started_ = true;
  return true;
}

bool ReachController::observe(const TargetObservation& observation) {
  if (observation.seen && !(observation.position.allFinite() && observation.velocity.allFinite())) return false;
  const bool orients = options_.task != TaskKind::kPosition && options_.orientation_frame == OrientationFrame::kTarget;
  std::optional<Eigen::Matrix3d> turned;
  if (observation.seen && orients && observation.orientation) turned = nearest_rotation(*observation.orientation);
  if (observation.seen && orients && !turned) return false;
  if (!is_plausible_time(observation.utime) || (newest_ && observation.utime < *newest_)) return false;
  newest_ = observation.utime;
  if (!observation.seen) return true;
  if (orients) {
    direction_ = (*turned * options_.direction).normalized();
    orientation_ = *turned * options_.orientation;
  }
  const bool jumped = filter_.update(observation);
  jumped_ = jumped_ || jumped;
  if (jumped && !planner_) note_jump(observation.utime);
  if (planner_) fall_.observe(observation.utime, observation.position, observation.covariance);
  last_seen_ = observation.utime;
  last_position_ = filter_.position_at(observation.utime);
  bring_tick_forward(observation.utime);
  return true;
}

/// Lets the next tick take up a target of this time, where the last one was long enough ago.
void ReachController::bring_tick_forward(int64_t utime) {
  if (options_.ticks != TickTimes::kOnTargets || !grid_origin_ || tick_ == 0) return;
  if (utime <= time_of_step(last_step_) || utime >= time_of_step(next_step_)) return;
  const int64_t step = (utime - *grid_origin_) * options_.steps_per_tick / options_.tick_us;
  if (kTicksWithin * (step - last_step_) >= options_.steps_per_tick) next_step_ = step;
}

/// Notices a target that jumps to and fro, e.g. between two objects of one colour: to follow each jump would only shake
/// the arm.
void ReachController::note_jump(int64_t utime) {
  std::rotate(jumps_.begin(), jumps_.end() - 1, jumps_.end());
  jumps_.front() = utime;
  if (jumps_.back() && utime - *jumps_.back() <= kFlickersWithin) flickers_ = true;
}

bool ReachController::observe_robot(const JointVector& theta) {
  if (theta.size() != chain_.size() || !theta.allFinite() || theta.cwiseAbs().maxCoeff() > kMaxAngle) return false;
  measured_ = theta;
  return true;
}

bool ReachController::restart_grid(int64_t utime) {
  if (!is_plausible_time(utime)) return false;
  grid_origin_ = utime;
  jumps_.fill(std::nullopt);
  flickers_ = false;
  tick_ = last_step_ = next_step_ = 0;
  if (newest_ && *newest_ > utime) newest_.reset();
  if (last_seen_ && *last_seen_ > utime) {
    last_seen_.reset();
    filter_.reset();
    forget_flight();
  }
  return true;
}

std::optional<int64_t> ReachController::next_tick() const {
  if (!grid_origin_) return std::nullopt;
  return time_of_step(next_step_);
}

/// `velocity`: m per integration step.
TaskTarget ReachController::task_target(const Eigen::Vector3d& position, const Eigen::Vector3d& velocity) const {
  return {.position = position,
          .velocity = velocity,
          .task = options_.task,
          .direction = direction_,
          .orientation = orientation_};
}

void ReachController::handle_lost_target() {
  jumped_ = true;  // treat the next target that is seen as a new one
  switch (options_.on_target_lost) {
    case OnTargetLost::kGoToRest:
      if (mode_ != ReachMode::kResting && law_->set_joint_target(rest_)) mode_ = ReachMode::kResting;
      return;
    case OnTargetLost::kStop:
      if (!dwelling_ && mode_ != ReachMode::kWaiting) law_->set_joint_target(chain_.clamped(law_->theta()));
      dwelling_ = true;
      break;
    case OnTargetLost::kHoldLastTarget:
      if (mode_ == ReachMode::kReaching && lost_) {
        law_->update_target(task_target(last_position_, Eigen::Vector3d::Zero()));
      }
      break;
  }
  if (mode_ != ReachMode::kWaiting) mode_ = ReachMode::kHolding;
}

void ReachController::track_target(int64_t now, int64_t begin) {
  if (flickers_ && now - *jumps_.front() >= kSteadyAfter) flickers_ = false;
  if (flickers_ && mode_ == ReachMode::kReaching) {
    law_->update_target(task_target(held_position_, Eigen::Vector3d::Zero()));
    return;
  }
  const int64_t then = begin + options_.prediction_us;
  const int64_t half =
      (now + options_.tick_us - begin) / 2;  // of this tick's steps, during which the velocity is constant
  const TaskTarget target =
      task_target(filter_.position_at(then), filter_.velocity_at(then + half) / steps_per_second());
  const bool resume = !jumped_ && mode_ == ReachMode::kReaching;
  const TargetResult result = resume ? law_->update_target(target) : law_->set_target(target);
  held_position_ = target.position;
  jumped_ = false;
  unreachable_ = result == TargetResult::kUnreachable;
  if (unreachable_ && std::holds_alternative<PaperParameters>(options_.law)) {
    handle_lost_target();
    return;
  }
  mode_ = ReachMode::kReaching;
  dwelling_ = false;
}

void ReachController::forget_flight() {
  fall_.reset();
  if (planner_) planner_->forget();
  interception_.reset();
}

/// Sends the hand to where it meets a target that falls freely; then, after a while, back to the rest configuration.
void ReachController::intercept_target(int64_t begin) {
  const int64_t then = begin + options_.prediction_us;
  if (interception_ && then > interception_->utime) {
    if (then <= interception_->utime + kAfterInterception) return;
    forget_flight();
  }
  const TaskTarget task = task_target(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  std::optional<Interception> chosen;
  if (!lost_) chosen = planner_->choose(static_cast<const GuardedLaw&>(*law_), fall_, then, rate_, task);
  if (chosen) {
    const TaskTarget target = task_target(chosen->position, Eigen::Vector3d::Zero());
    const bool same = interception_ && interception_->utime == chosen->utime && mode_ == ReachMode::kReaching;
    if (same)
      law_->update_target(target);
    else
      law_->set_target(target);
    interception_ = chosen;
    mode_ = ReachMode::kReaching;
  } else if (!interception_ && mode_ != ReachMode::kResting && law_->set_joint_target(rest_)) {
    mode_ = ReachMode::kResting;
  }
}

/// `begin`: the time for which the joint positions hold before this tick, one period after the last. A moving target is
/// predicted to it.
void ReachController::update_goal(int64_t now, int64_t begin) {
  lost_ = !last_seen_ || now - *last_seen_ > options_.lost_after_us;
  unreachable_ = false;
  if (planner_) {
    intercept_target(begin);
  } else if (!lost_) {
    track_target(now, begin);
  } else if (last_seen_ || mode_ != ReachMode::kWaiting) {
    handle_lost_target();
  }
}

void ReachController::record_command() {
  commands_[static_cast<size_t>(commands_recorded_ % kCommandHistory)] = {law_->theta(), due_steps_};
  ++commands_recorded_;
}

/// `interval_us`: the time that this tick stands for. Its steps are counted in due_steps_ already.
void ReachController::compensate_disturbance(int64_t interval_us) {
  if (options_.feedback != Feedback::kMeasured) return;
  JointVector displacement = JointVector::Zero(chain_.size());
  if (measured_) {
    const auto known = static_cast<int>(std::min<int64_t>(commands_recorded_, kCommandHistory));
    const int64_t oldest = due_steps_ - int64_t{kCommandsWithin} * options_.steps_per_tick;
    for (int i = 0; i < chain_.size(); ++i) {
      double low = law_->theta()[i], high = low;
      for (int k = 0; k < known; ++k) {
        const PastCommand& command = commands_[static_cast<size_t>(k)];
        if (command.step < oldest) continue;
        low = std::min(low, command.theta[i]);
        high = std::max(high, command.theta[i]);
      }
      // Deviation from the range of the commands of the last 0.3 s, after removing the learnt offset.
      const double there = (*measured_)[i] - offset_[i], beside = there - std::clamp(there, low, high);
      offset_[i] +=
          std::min(1.0, static_cast<double>(interval_us) / kOffsetAfter) * std::clamp(beside, -kMaxOffset, kMaxOffset);
      displacement[i] = std::copysign(std::max(std::abs(beside) - options_.disturbance_threshold, 0.0), beside);
    }
  }
  measured_.reset();
  law_->compensate(displacement);
}

/// Whether the arm has come to rest short of a target that no limit of its own keeps it from, and why. A robot that the
/// bridge slows down is not blocked.
Blocked ReachController::blocked(double distance_m, int64_t interval_us) {
  const JointVector theta = law_->theta();
  if (rested_.size() != theta.size() || (theta - rested_).cwiseAbs().maxCoeff() > kStill || rate_ < 1) {
    rested_ = theta;
    still_us_ = 0;
  } else {
    still_us_ += interval_us;
  }
  // A hand that waits for a thrown target is not blocked.
  if (mode_ != ReachMode::kReaching || planner_ || distance_m < kArrived || still_us_ < kStillFor) return Blocked::kNo;
  const Obstruction obstruction = law_->obstruction();
  if (obstruction == Obstruction::kTarget) return Blocked::kTargetInObstacle;
  if (unreachable_) return Blocked::kNo;
  return obstruction == Obstruction::kObstacle ? Blocked::kObstacle : Blocked::kUnknown;
}

void ReachController::set_rate(double rate) {
  if (rate >= 0 && rate <= 1) rate_ = rate;
}

ReachOutput ReachController::tick() {
  ReachOutput output;
  if (!started_ || !grid_origin_) {
    output.mode = ReachMode::kNotStarted;
    return output;
  }
  output.utime = *next_tick();
  output.tick = tick_++;
  // The first tick stands for as much time as if one had been before it.
  const int64_t due = output.tick == 0 ? options_.steps_per_tick : next_step_ - last_step_;
  const int64_t interval_us = due * options_.tick_us / options_.steps_per_tick;
  last_step_ = next_step_;
  next_step_ += options_.steps_per_tick;
  due_steps_ += due;
  update_goal(output.utime, output.utime + options_.tick_us - interval_us);
  compensate_disturbance(interval_us);
  owed_steps_ += rate_ * static_cast<double>(due);
  const int steps = static_cast<int>(owed_steps_);
  owed_steps_ -= steps;
  if (mode_ != ReachMode::kWaiting) {
    for (int k = 0; k < steps; ++k) law_->step();
  }
  record_command();
  if (mode_ == ReachMode::kReaching) unreachable_ = law_->unreachable();
  if (last_seen_) output.distance_m = (last_position_ - law_->x()).norm();
  output.blocked = blocked(output.distance_m, interval_us);
  output.mode = mode_;
  output.target_lost = lost_;
  output.target_unreachable = unreachable_;
  output.target_flickers = flickers_ && mode_ == ReachMode::kReaching;
  output.theta = law_->theta();
  output.velocity = law_->velocity() * (steps_per_second() * steps / static_cast<double>(due));
  output.theta_target = law_->theta_target();
  output.x = law_->x();
  output.x_T = mode_ == ReachMode::kWaiting ? law_->x() : law_->x_target();
  output.weights = law_->weights();
  output.gamma = law_->gamma();
  Eigen::Vector3d x;
  PositionJacobian jacobian;
  chain_.position_and_jacobian(output.theta, x, jacobian);
  output.condition_number = condition_number(coherence_matrix(jacobian, output.weights));
  output.attractor_residual_m = law_->residual_m();
  output.ik_searches = law_->ik_searches();
  output.interception = interception_;
  return output;
}

}  // namespace multireach::controller
