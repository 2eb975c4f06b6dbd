#include "controller/law/guarded_law.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "controller/task/target_check.hpp"
#include "numeric/random.hpp"

namespace multireach::controller {
namespace {

using Tuning = GuardedTuning;

/// An unreachable target is searched for again when it has moved this far, m.
constexpr double kSameTarget = 1e-3;
/// Steps (StepPace) for which an obstacle may stop the arm before a path is planned; doubled after every failure ...
constexpr int kStepsUntilPlan = 35;
/// ... up to this many.
constexpr int kMaxStepsUntilPlan = 1400;
/// Largest displacement that is compensated, rad (m).
constexpr double kMaxDisturbance = 3;
/// Distance at which a configuration of a path counts as passed, rad (m).
constexpr double kPassed = 0.15;
/// Random starts tried to find a collision-free IK solution.
constexpr int kCollisionFreeTries = 60;
/// Work of computing a clearance, in units of MultiStartIk::continue_search().
constexpr int kClearanceWork = 6;
/// Work of a plan in one step, in units of RrtPlanner::continue_planning(), as long as one unit of a search.
constexpr int kPlanWork = 2;
constexpr int kAllWork = std::numeric_limits<int>::max();

}  // namespace

GuardedLaw::GuardedLaw(const Chain& chain, const GuardedParameters& parameters)
    : chain_(chain),
      parameters_(parameters),
      arm_{FastLinks<0, Double2>(chain, tool_frame(parameters.tool)), tool_frame(parameters.tool),
           guarded_settings(chain, parameters)},
      search_(chain, guarded_ik_options(chain, parameters), parameters.tool),
      solver_(chain, parameters.tool, search_.options().joint_weights),
      proximity_(chain, parameters.body),
      planner_(chain, search_.locked()) {
  if (parameters.path_work > 0) reach_path_.emplace(chain, arm_.settings, solver_, parameters.path_work);
  start(chain.clamped(JointVector::Zero(chain.size())));
  started_ = false;  // the position of the arm is not known yet
}

void GuardedLaw::take_motion(const GuardedLaw& other) {
  state_ = other.state_;
  state_.target_fixed = state_.obstructed = false;
  target_ = other.target_;
  requested_target_ = other.requested_target_;
  started_ = other.started_;
  posture_only_ = other.posture_only_;
  searching_ = other.searching_ && !other.collision_free_search_;
  ik_search_ = other.ik_search_;
  collision_free_search_.reset();
  steps_since_update_ = other.steps_since_update_;
  searched_target_ = other.searched_target_;
  path_.clear();
  path_next_ = 0;
  planning_.reset();
  obstructed_steps_ = 0;
}

bool GuardedLaw::start(const JointVector& theta) {
  if (theta.size() != chain_.size() || !theta.allFinite() || theta.cwiseAbs().maxCoeff() > kMaxAngle) return false;
  state_ = GuardedState{};
  const JointVector inside = solver_.clamped(theta);
  for (int i = 0; i < chain_.size(); ++i) {
    state_.theta[i] = theta[i];
    state_.theta_target[i] = inside[i];
  }
  GuardedProgress<double>& progress = state_.progress;
  progress.residual = std::numeric_limits<double>::infinity();
  progress.damping_factor = 1;
  progress.steps_to_check = arm_.settings.pace.check_every;
  target_.reset();
  started_ = true;
  begin_reach(false);
  obstructed_steps_ = 0;
  update_kinematics(arm_, state_);
  state_.last_target = state_.position(0);
  return true;
}

void GuardedLaw::begin_reach(bool posture_only) {
  posture_only_ = posture_only;
  state_.target_fixed = posture_only;
  searching_ = false;
  state_.progress.unreachable = 0;
  path_.clear();
  path_next_ = 0;
  planning_.reset();
  if (reach_path_) reach_path_->stop();
  steps_until_plan_ = arm_.settings.pace.steps(kStepsUntilPlan);
  restart_schedule(arm_, state_);
}

Obstruction GuardedLaw::obstruction() const {
  const bool moved_out = target_ && !posture_only_ && target_->position != requested_target_.position;
  if (moved_out) return Obstruction::kTarget;
  return state_.obstructed || following_path() ? Obstruction::kObstacle : Obstruction::kNone;
}

int GuardedLaw::set_obstacles(std::span<const Obstacle> obstacles) {
  if (parameters_.body.link_radius_m <= 0) return static_cast<int>(obstacles.size());
  // A sender that repeats them ends neither a path nor its plan.
  if (std::ranges::equal(obstacles, proximity_.obstacles())) return 0;
  planning_.reset();
  const int refused = proximity_.set_obstacles(obstacles);
  if (following_path()) end_path();
  if (following_short_path()) release_theta_target(theta_target());
  if (reach_path_) reach_path_->stop();
  if (target_ && !posture_only_) target_->position = proximity_.outside_obstacles(requested_target_.position);
  return refused;
}

CollisionFreeSearch GuardedLaw::collision_free_search(const TaskTarget& target, uint64_t seed, bool nearest) const {
  return {.target = target, .theta = theta(), .seed = seed, .nearest = nearest};
}

bool GuardedLaw::continue_search(CollisionFreeSearch& search, int work) {
  const double tolerance = search_.options().tolerance_m;
  while (!search.finished && work > 0) {
    if (!search.descends) {
      search.descent = IkDescent{search.theta};
      search_.draw(CounterRandom(search.seed, 11), search.counter, search_.locked(), search.descent.posture);
      search.descends = true;
    }
    work -= solver_.descend(search.target, search.descent, tolerance, work);
    if (!search.descent.finished) continue;
    search.descends = false;
    ++search.tries;
    const JointVector& posture = search.descent.posture;
    const bool nearer =
        !search.best || solver_.distance(posture, search.theta) < solver_.distance(*search.best, search.theta);
    if (search.descent.error <= tolerance && nearer) {
      if (proximity_.clearance(posture) >= 0) search.best = posture;
      work -= kClearanceWork;
    }
    search.finished = search.tries >= kCollisionFreeTries || (search.best && !search.nearest);
  }
  return search.finished;
}

void GuardedLaw::end_path() {
  if (path_.empty()) return;
  const JointVector goal = path_.back();
  path_.clear();
  path_next_ = 0;
  release_theta_target(goal);
}

void GuardedLaw::release_theta_target(const JointVector& theta_target) {
  state_.target_fixed = posture_only_;
  restart_schedule(arm_, state_);
  set_theta_target(theta_target);
}

void GuardedLaw::follow_path() {
  while (following_path() && (path_[path_next_] - theta()).norm() < kPassed) ++path_next_;
  if (!following_path()) {
    end_path();
    return;
  }
  if (theta_target() == path_[path_next_]) return;
  for (int i = 0; i < chain_.size(); ++i) state_.theta_target[i] = path_[path_next_][i];
  update_kinematics(arm_, state_);
}

void GuardedLaw::begin_plan() {
  obstructed_steps_ = 0;
  // Plan to theta_T; at every second attempt, to another collision-free IK solution of the target.
  planning_ = Planning{.start = theta(),
                       .goal = following_path() ? path_.back() : JointVector(theta_target()),
                       .target = target_->position,
                       .to_go_m = (target_->position - x()).norm()};
  const uint64_t seed = search_.options().seed + plans_;
  if (plans_++ % 2 == 1 && !posture_only_) planning_->other_goal = collision_free_search(*target_, seed, false);
}

/// Whether what the plan began from has changed: where the arm is, or where it is to go.
bool GuardedLaw::plan_is_outdated() const {
  return (theta() - planning_->start).norm() > kPassed ||
         (target_->position - planning_->target).norm() > 0.5 * planning_->to_go_m ||
         planning_->free_steps >= arm_.settings.pace.steps(kStepsUntilPlan);
}

void GuardedLaw::plan_around_obstruction() {
  const bool obstructed = state_.obstructed && state_.slow;
  if (planning_) {
    planning_->free_steps = obstructed ? 0 : planning_->free_steps + 1;
    if (plan_is_outdated()) planning_.reset();
  }
  if (!planning_) {
    obstructed_steps_ = obstructed ? obstructed_steps_ + 1 : 0;
    if (obstructed_steps_ >= steps_until_plan_) begin_plan();
    return;
  }
  const StepPace& pace = arm_.settings.pace;
  if (auto& other = planning_->other_goal) {
    if (!continue_search(*other, pace.search_work(target_->task))) return;
    planning_->goal = other->best.value_or(planning_->goal);
    other.reset();
    return;
  }
  if (!planning_->has_begun) {
    planning_->has_begun = true;
    // The planner cannot reach a goal that penetrates obstacles more deeply than the arm does now.
    if (proximity_.clearance(planning_->goal) >= std::min(0.0, proximity_.clearance(theta())) - 1e-6) {
      planner_.begin(theta(), planning_->goal, proximity_, search_.options().seed + plans_ - 1);
      return;
    }
  } else if (!planner_.continue_planning(proximity_, kPlanWork * pace.search_work(TaskKind::kPosition))) {
    return;
  } else if (!planner_.path().empty() && planner_.path().size() <= Path::kCapacity) {
    if (!obstructed) return;  // free at the moment: perhaps the path is not needed
    planning_.reset();
    begin_path();
    return;
  }
  planning_.reset();
  steps_until_plan_ = std::min(2 * steps_until_plan_, pace.steps(kMaxStepsUntilPlan));
  if (following_path()) end_path();
}

/// Follows the path that the planner has found.
void GuardedLaw::begin_path() {
  path_.clear();
  // When the arm starts outside its limits, so does the planned path: clamp it.
  for (const JointVector& posture : planner_.path()) path_.push_back(solver_.clamped(posture));
  path_next_ = 0;
  if (reach_path_) reach_path_->stop();
  state_.target_fixed = true;
  state_.gamma = 0;  // follow the planned joint path: no straight hand path
  follow_path();
}

JointVector GuardedLaw::with_locked_joints(JointVector posture) const {
  for (int i = 0; i < chain_.size(); ++i) {
    if (search_.locked()[i]) posture[i] = state_.theta[i];
  }
  return posture;
}

void GuardedLaw::set_theta_target(const JointVector& theta_target) {
  const JointVector posture = with_locked_joints(theta_target);
  for (int i = 0; i < chain_.size(); ++i) state_.theta_target[i] = posture[i];
  searching_ = false;
  GuardedProgress<double>& progress = state_.progress;
  progress.stuck = 0;
  progress.checked_residual = std::numeric_limits<double>::infinity();
  progress.distance_at_choice = distance_to_go();
  progress.no_search_before = progress.steps + arm_.settings.pace.quiet;
  searched_target_ = target_->position;
  update_kinematics(arm_, state_);
}

void GuardedLaw::begin_search() {
  searching_ = true;
  search_.begin(*target_, theta(), ik_search_);
  collision_free_search_.reset();
  ++ik_searches_;
}

bool GuardedLaw::continue_search(int work) {
  const IkSolution& found = ik_search_.best;
  const auto reachable = [&] { return found.error_m <= Tuning::kReached; };
  if (!collision_free_search_) {
    if (!search_.continue_search(ik_search_, work)) return false;
    if (reachable() && !proximity_.nothing_to_avoid() && proximity_.clearance(found.theta) < 0) {
      collision_free_search_ = collision_free_search(ik_search_.target, search_.options().seed, true);
      return false;
    }
  } else if (!continue_search(*collision_free_search_, work)) {
    return false;
  }
  state_.progress.unreachable = reachable() ? 0 : 1;
  set_theta_target(collision_free_search_ ? collision_free_search_->best.value_or(found.theta) : found.theta);
  searched_target_ = ik_search_.target.position;
  return true;
}

void GuardedLaw::assign_target(const TaskTarget& target) {
  if (!target_ || target_->task != target.task)
    std::fill(state_.hand_velocity.begin() + 3, state_.hand_velocity.end(), 0);
  const bool first = !target_;
  steps_since_update_ = 0;
  requested_target_ = within_ten_reaches(chain_, target);
  target_ = requested_target_;
  target_->position = proximity_.outside_obstacles(requested_target_.position);
  if (!first) return;
  for (int k = 0; k < 3; ++k) state_.awaited[k] = state_.checked_target[k] = target_->position[k];
}

TargetResult GuardedLaw::set_target(const TaskTarget& target) {
  if (!started_) return TargetResult::kNotStarted;
  const auto checked = checked_target(target);
  if (!checked) return TargetResult::kRefused;
  assign_target(*checked);
  begin_reach(false);
  begin_search();
  while (!continue_search(kAllWork)) continue;
  if (reach_path_ && !unreachable()) reach_path_->begin(arm_, state_, *target_);
  return unreachable() ? TargetResult::kUnreachable : TargetResult::kReachable;
}

TargetResult GuardedLaw::set_target(const TaskTarget& target, const JointVector& theta_target) {
  const bool posture = theta_target.size() == chain_.size() && theta_target.allFinite() &&
                       chain_.limit_excess(theta_target) <= 0 && theta_target.cwiseAbs().maxCoeff() <= kMaxAngle;
  if (!started_) return TargetResult::kNotStarted;
  const auto checked = checked_target(target);
  if (!checked || !posture) return TargetResult::kRefused;
  assign_target(*checked);
  begin_reach(false);
  set_theta_target(theta_target);
  return TargetResult::kReachable;
}

TargetResult GuardedLaw::update_target(const TaskTarget& target) {
  if (!target_ || posture_only_ || target.task != target_->task) return set_target(target);
  const auto checked = checked_target(target);
  if (!checked) return TargetResult::kRefused;
  assign_target(*checked);
  return unreachable() ? TargetResult::kUnreachable : TargetResult::kReachable;
}

bool GuardedLaw::set_joint_target(const JointVector& theta) {
  if (theta.size() != chain_.size() || !theta.allFinite() || chain_.limit_excess(theta) > 0) return false;
  if (!started_ || theta.cwiseAbs().maxCoeff() > kMaxAngle) return false;
  target_ = TaskTarget{.position = chain_.position(with_locked_joints(theta))};
  begin_reach(true);
  set_theta_target(theta);
  return true;
}

void GuardedLaw::compensate(const JointVector& displacement) {
  if (displacement.size() != chain_.size() || !displacement.allFinite()) return;
  // As strong as the joints' attractor at five times this distance.
  for (int i = 0; i < chain_.size(); ++i) {
    state_.disturbance[i] =
        5 * arm_.settings.gains.beta * std::clamp(displacement[i], -kMaxDisturbance, kMaxDisturbance);
  }
}

double GuardedLaw::distance_to_go() const {
  double sum = 0;
  for (int i = 0; i < chain_.size(); ++i) {
    const double apart = state_.theta_target[i] - state_.theta[i];
    sum += apart * apart;
  }
  return std::sqrt(sum);
}

void GuardedLaw::search_if_needed() {
  if (posture_only_) return;
  if (!searching_) {
    if (state_.progress.steps < state_.progress.no_search_before) return;
    const bool unchanged = (target_->position - searched_target_).norm() < kSameTarget;
    if (!needs_search(arm_, *target_, unchanged, state_)) return;
    begin_search();
  }
  continue_search(arm_.settings.pace.search_work(target_->task));
}

void GuardedLaw::step() {
  if (!started_) return;
  if (target_ && reach_path_) reach_path_->before_step(arm_, *target_, proximity_, state_);
  const std::span<const ProximityPair> pairs =
      proximity_.nothing_to_avoid() ? std::span<const ProximityPair>{} : proximity_.near_pairs(theta());
  if (!target_) {
    TaskTarget stay{.position = x()};
    state_.target_fixed = true;
    bounded_solves_ += guarded_step(arm_, stay, pairs, state_);
    return;
  }
  bounded_solves_ += guarded_step(arm_, *target_, pairs, state_);
  if (++steps_since_update_ > parameters_.extrapolation_s * parameters_.steps_per_second) target_->velocity.setZero();
  target_->position += target_->velocity;
  requested_target_.position += target_->velocity;
  if (reach_path_ && reach_path_->after_step(state_)) release_theta_target(theta_target());
  if (!pairs.empty()) {
    plan_around_obstruction();
  } else {
    planning_.reset();
  }
  if (following_path()) {
    follow_path();
  } else if (!following_short_path() && !planning()) {
    search_if_needed();
  }
}

}  // namespace multireach::controller
