#include "controller/intercept/interception_planner.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "controller/intercept/least_time.hpp"
#include "controller/law/guarded_settings.hpp"
#include "kinematics/default_limits.hpp"

namespace multireach::controller {
namespace {

// Chosen by judgement, not fitted to throws:
constexpr int64_t kTimeStep = 20000;  // us: interceptions are at whole multiples, so that the next call finds the same
constexpr int64_t kDecided = 100000;  // us: one that is nearer than this is not exchanged: three images
constexpr double kClearlyBetter = 0.64;  // of the squared error: four fifths of the error
constexpr double kSolved = 1e-4;         // m

double expected_square(const Interception& one) {
  return one.error_m * one.error_m + one.sigma_m * one.sigma_m;
}

bool within_reach(const Chain& chain, const Eigen::Vector3d& position) {
  return (position - chain.fixed(0).translation()).norm() <= chain.reach();
}

/// A position that is hard to reach is none to intercept at.
IkOptions with_few_starts(IkOptions options) {
  options.most_starts = std::min(options.most_starts, 2);
  options.tolerance_m = kSolved;
  return options;
}

GuardedParameters without_body(GuardedParameters parameters) {
  parameters.body = {};
  parameters.path_work = 0;
  return parameters;
}

}  // namespace

InterceptionPlanner::InterceptionPlanner(const Chain& chain, const GuardedParameters& parameters)
    : simulated_(chain, without_body(parameters)),
      search_(chain, with_few_starts(guarded_ik_options(chain, parameters)), parameters.tool),
      speed_(chain.velocity().cwiseMin(kSpeedWhereUnlimited)),
      acceleration_(parameters.acceleration.size() > 0 ? parameters.acceleration : default_acceleration(speed_)),
      steps_per_second_(parameters.steps_per_second) {}

/// `is_last`: the law goes there already: its theta_T follows without a search.
std::optional<Interception> InterceptionPlanner::simulate(const GuardedLaw& law, const FreeFallFilter& object,
                                                          int64_t begin, double rate, int64_t at, TaskTarget task,
                                                          bool is_last) {
  const std::optional<FallingObject> there = object.at(at);
  if (!there || !within_reach(law.chain(), there->position)) return std::nullopt;
  simulated_.take_motion(law);
  task.position = there->position;
  const TargetResult result = is_last ? simulated_.update_target(task) : simulated_.set_target(task);
  if (result != TargetResult::kReachable) return std::nullopt;
  const auto steps = std::lround(1e-6 * static_cast<double>(at - begin) * steps_per_second_ * rate);
  for (long k = 0; k < steps; ++k) simulated_.step();
  const Interception one{.utime = at,
                         .position = there->position,
                         .sigma_m = std::sqrt(there->covariance.trace()),
                         .error_m = (simulated_.x() - there->position).norm()};
  if (!(expected_square(one) <= kLargestError * kLargestError)) return std::nullopt;
  return one;
}

std::optional<Interception> InterceptionPlanner::choose(const GuardedLaw& law, const FreeFallFilter& object,
                                                        int64_t begin, double rate, const TaskTarget& task) {
  std::optional<Interception> best;
  if (last_ && last_->utime > begin) best = simulate(law, object, begin, rate, last_->utime, task, true);
  if (best && best->utime - begin < kDecided) return last_ = best;
  // Times at which the object is within reach, then an even choice of them.
  std::array<int64_t, kHorizon / kTimeStep + 1> times{};
  int number = 0;
  for (int64_t at = (begin / kTimeStep + 1) * kTimeStep; at <= begin + kHorizon; at += kTimeStep) {
    const std::optional<FallingObject> there = object.at(at);
    if (there && within_reach(law.chain(), there->position)) times[static_cast<size_t>(number++)] = at;
  }
  const int searches = std::min(number, kSearches);
  std::array<Candidate, kSearches> candidates{};
  int reachable = 0;
  TaskTarget target = task;
  JointVector near = law.theta();
  for (int k = 0; k < searches; ++k) {
    const int64_t at = times[static_cast<size_t>((2 * k + 1) * number / (2 * searches))];
    target.position = object.at(at)->position;
    const IkSolution found = search_.first(target, near);
    if (found.error_m > kSolved) continue;
    near = found.theta;  // the next position is near this one
    const double needed = least_time(found.theta - law.theta(), speed_, acceleration_);
    candidates[static_cast<size_t>(reachable++)] = {at, 1e-6 * static_cast<double>(at - begin) - needed};
  }
  double least = best ? kClearlyBetter * expected_square(*best) : std::numeric_limits<double>::infinity();
  for (int part = 0; part < kSimulations; ++part) {
    const auto first = candidates.begin() + part * reachable / kSimulations,
               last = candidates.begin() + (part + 1) * reachable / kSimulations;
    if (first == last) continue;
    const int64_t at = std::ranges::max_element(first, last, {}, &Candidate::spare_s)->utime;
    if (best && at == best->utime) continue;
    const std::optional<Interception> other = simulate(law, object, begin, rate, at, task, false);
    if (!other || !(expected_square(*other) < least)) continue;
    least = expected_square(*other);
    best = other;
  }
  return last_ = best;
}

}  // namespace multireach::controller
