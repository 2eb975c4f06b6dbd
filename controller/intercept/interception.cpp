#include "controller/intercept/interception.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "controller/intercept/least_time.hpp"
#include "kinematics/default_limits.hpp"

namespace multireach::controller {
namespace {

constexpr int64_t kTimeStep = 20000;  // us: meetings are at whole multiples, so that the next call finds the same times
constexpr int64_t kDecided = 100000;  // us: a meeting nearer than this is not exchanged for another
constexpr double kClearlyBetter = 0.64;  // of the squared distance
constexpr double kSolved = 1e-4;         // m

double expected_square(const Meeting& meeting) {
  return meeting.miss_m * meeting.miss_m + meeting.sigma_m * meeting.sigma_m;
}

/// A place that is hard to reach is none to meet a body.
IkOptions with_few_starts(IkOptions options) {
  options.most_starts = std::min(options.most_starts, 2);
  options.tolerance_m = kSolved;
  return options;
}

bool within_reach(const Chain& chain, const Eigen::Vector3d& position) {
  return (position - chain.fixed(0).translation()).norm() <= chain.reach();
}

}  // namespace

Interception::Interception(const GuardedLaw& law, const GuardedParameters& parameters)
    : rehearsed_(law),
      search_(law.chain(), with_few_starts(parameters.ik), parameters.tool),
      speed_(law.chain().velocity().cwiseMin(kSpeedWhereUnlimited)),
      acceleration_(parameters.acceleration.size() > 0 ? parameters.acceleration : default_acceleration(speed_)),
      steps_per_second_(parameters.steps_per_second) {}

/// `chosen_already`: the law goes to this meeting: its theta_T follows without a search.
std::optional<Meeting> Interception::rehearse(const GuardedLaw& law, const FreeFallFilter& body, int64_t begin,
                                              int64_t at, TaskTarget task, bool chosen_already) {
  const std::optional<FallingBody> there = body.at(at);
  if (!there || !within_reach(law.chain(), there->position)) return std::nullopt;
  rehearsed_ = law;
  task.position = there->position;
  const TargetResult result = chosen_already ? rehearsed_.update_target(task) : rehearsed_.set_target(task);
  if (result != TargetResult::kReachable) return std::nullopt;
  const auto steps = static_cast<int>(1e-6 * static_cast<double>(at - begin) * steps_per_second_);
  for (int k = 0; k < steps; ++k) rehearsed_.step();
  return Meeting{.utime = at,
                 .position = there->position,
                 .sigma_m = std::sqrt(there->covariance.trace()),
                 .miss_m = (rehearsed_.x() - there->position).norm()};
}

std::optional<Meeting> Interception::choose(const GuardedLaw& law, const FreeFallFilter& body, int64_t begin,
                                            const TaskTarget& task) {
  if (!body.falls()) {
    meeting_.reset();
    return std::nullopt;
  }
  std::optional<Meeting> best;
  if (meeting_ && meeting_->utime > begin) best = rehearse(law, body, begin, meeting_->utime, task, true);
  if (best && best->utime - begin < kDecided) return meeting_ = best;
  // Times at which the body is within reach, then an even choice of them.
  std::array<int64_t, kHorizon / kTimeStep + 1> times{};
  int number = 0;
  for (int64_t at = (begin / kTimeStep + 1) * kTimeStep; at <= begin + kHorizon; at += kTimeStep) {
    const std::optional<FallingBody> there = body.at(at);
    if (there && within_reach(law.chain(), there->position)) times[static_cast<size_t>(number++)] = at;
  }
  const int searches = std::min(number, kSearches);
  std::array<Candidate, kSearches> candidates{};
  int reachable = 0;
  TaskTarget target = task;
  JointVector near = law.theta();
  for (int k = 0; k < searches; ++k) {
    const int64_t at = times[static_cast<size_t>((2 * k + 1) * number / (2 * searches))];
    target.position = body.at(at)->position;
    const IkSolution found = search_.first(target, near);
    if (found.error_m > kSolved) continue;
    near = found.theta;  // the next place is beside this one
    const double needed = least_time(found.theta - law.theta(), speed_, acceleration_);
    candidates[static_cast<size_t>(reachable++)] = {at, 1e-6 * static_cast<double>(at - begin) - needed};
  }
  double least = best ? kClearlyBetter * expected_square(*best) : std::numeric_limits<double>::infinity();
  for (int part = 0; part < kRehearsals; ++part) {
    const auto first = candidates.begin() + part * reachable / kRehearsals,
               last = candidates.begin() + (part + 1) * reachable / kRehearsals;
    if (first == last) continue;
    const int64_t at = std::ranges::max_element(first, last, {}, &Candidate::spare_s)->utime;
    if (best && at == best->utime) continue;
    const std::optional<Meeting> other = rehearse(law, body, begin, at, task, false);
    if (!other || !(expected_square(*other) < least)) continue;
    least = expected_square(*other);
    best = other;
  }
  return meeting_ = best;
}

}  // namespace multireach::controller
