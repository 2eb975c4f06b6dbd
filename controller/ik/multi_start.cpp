#include "controller/ik/multi_start.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "numeric/random.hpp"

namespace multireach::controller {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
/// A target further away than this many reaches is moved to that distance. Only its direction matters, and huge numbers
/// then do no harm.
constexpr double kFar = 10;
/// Share of the reach: for an unreachable target, errors that differ by less than this count as equal, and the
/// configuration nearer to the start wins.
constexpr double kAsGood = 1e-3;
/// A joint is heavy when it weighs this many times as much as the lightest.
constexpr double kHeavy = 4;

}  // namespace

MultiStartIk::MultiStartIk(const Chain& chain, const IkOptions& options, const Tool& tool)
    : chain_(chain), options_(options), solver_(chain, tool, options.joint_weights) {
  const JointVector& weights = options.joint_weights;
  if (weights.size() == 0 || (weights.array() == weights[0]).all()) {
    closed_form_ik_ = ClosedFormIk::from(chain, options.samples);  // it knows no weights
    return;
  }
  JointVector light = weights;
  bool some_heavy = false;
  for (int i = 0; i < chain.size(); ++i) {
    locked_[i] = !std::isfinite(weights[i]);
    heavy_[i] = weights[i] >= kHeavy * weights.minCoeff();
    if (!heavy_[i]) continue;
    some_heavy = some_heavy || !locked_[i];
    light[i] = std::numeric_limits<double>::infinity();
  }
  if (some_heavy) light_solver_.emplace(chain, tool, light);
}

void MultiStartIk::draw(const CounterRandom& random, uint64_t& counter, const JointSet& fixed,
                        JointVector& posture) const {
  for (int i = 0; i < chain_.size(); ++i) {
    const double drawn = random.uniform(counter++, chain_.sample_lower(i), chain_.sample_upper(i));
    if (!fixed[i]) posture[i] = drawn;
  }
}

std::optional<JointVector> MultiStartIk::nearest(const Eigen::Vector3d& x_T, const JointVector& theta) const {
  if (!x_T.allFinite() || !theta.allFinite()) return std::nullopt;
  const IkSolution found = best({.position = x_T}, theta);
  if (found.error_m > options_.tolerance_m) return std::nullopt;
  return found.theta;
}

TaskTarget within_ten_reaches(const Chain& chain, TaskTarget target) {
  const Eigen::Vector3d shoulder = chain.fixed(0).translation(), from_shoulder = target.position - shoulder;
  const double distance = from_shoulder.stableNorm(), far = kFar * chain.reach();
  if (distance > far) {
    target.position = shoulder + from_shoulder.stableNormalized() * far;
    target.velocity.setZero();
  }
  const double speed = target.velocity.stableNorm();
  if (speed > chain.reach()) target.velocity = target.velocity.stableNormalized() * chain.reach();
  return target;
}

IkSolution MultiStartIk::best(const TaskTarget& target, const JointVector& theta) const {
  IkSearch search;
  begin(target, theta, search);
  while (!continue_search(search, std::numeric_limits<int>::max())) continue;
  return search.best;
}

void MultiStartIk::begin(const TaskTarget& target, const JointVector& theta, IkSearch& search) const {
  search = {};
  search.target = within_ten_reaches(chain_, target);
  search.theta = theta;
  if (closed_form_ik_ && target.task == TaskKind::kPosition) return;
  begin_starts(light_solver_.has_value(), theta, search);
}

void MultiStartIk::begin_starts(bool light, const JointVector& theta, IkSearch& search) const {
  const double infinity = std::numeric_limits<double>::infinity();
  search.phase = IkSearch::Phase::kStarts;
  search.light = light;
  search.best = {solver_of(search).clamped(theta), infinity};
  search.start = search.solutions = search.approached = 0;
  search.counter = 0;
  search.least = infinity;
  search.distance.fill(infinity);
}

bool MultiStartIk::continue_search(IkSearch& search, int work) const {
  if (!search.finished && search.phase == IkSearch::Phase::kClosedForm) {
    // All solutions inside the limits may lie between two samples; then the random starts continue.
    if (auto posture = closed_form_ik_->nearest(search.target.position, search.theta)) {
      search.best = {*posture, solver_.error(search.target, *posture)};
      search.finished = true;
    } else {
      begin_starts(false, search.theta, search);
    }
    return search.finished;
  }
  while (!search.finished && work > 0) {
    work -= search.phase == IkSearch::Phase::kStarts ? continue_starts(search, work) : continue_approach(search, work);
  }
  return search.finished;
}

IkSolution MultiStartIk::first(const TaskTarget& target, const JointVector& theta) const {
  const TaskTarget near = within_ten_reaches(chain_, target);
  const CounterRandom random(options_.seed);
  IkSolution best{solver_.clamped(theta), std::numeric_limits<double>::infinity()};
  JointVector posture = best.theta;
  uint64_t counter = 0;
  for (int start = 0; start <= options_.most_starts; ++start) {
    if (start > 0) draw(random, counter, locked_, posture);
    const double error = solver_.solve(near, posture, options_.tolerance_m);
    if (error < best.error_m) best = {posture, error};
    if (error <= options_.tolerance_m) break;
  }
  return best;
}

int MultiStartIk::continue_starts(IkSearch& search, int work) const {
  const LevenbergMarquardtIk& solver = solver_of(search);
  const JointSet& fixed = search.light ? heavy_ : locked_;
  // A search with heavy joints at rest begins from inside the limits.
  const JointVector theta = search.light ? solver_.clamped(search.theta) : search.theta;
  if (!search.descends) {
    const int most_starts = search.light ? options_.starts : options_.most_starts;
    const bool enough =
        search.solutions >= options_.solutions || (search.solutions > 0 && search.start > options_.starts);
    if (search.start > most_starts || enough) {
      search.phase = IkSearch::Phase::kApproach;
      if (search.solutions > 0) return 0;
      search.finished = !search.light;
      if (search.light) begin_starts(false, search.theta, search);
      return 0;
    }
    search.descent = IkDescent{solver.clamped(theta)};
    if (search.start > 0) draw(CounterRandom(options_.seed), search.counter, fixed, search.descent.posture);
    search.descends = true;
  }
  const int used = solver.descend(search.target, search.descent, options_.tolerance_m, work);
  if (!search.descent.finished) return used;
  search.descends = false;
  ++search.start;
  JointVector& posture = search.descent.posture;
  const double error = search.descent.error;
  for (int i = 0; i < chain_.size(); ++i) {
    if (!chain_.joint(i).limited() && !fixed[i]) posture[i] -= kTurn * std::round((posture[i] - theta[i]) / kTurn);
  }
  // Of two configurations with nearly the same error, e.g. two stretched ones, prefer the one nearer to theta.
  const double slack = kAsGood * chain_.reach(), distance = solver_.distance(posture, theta);
  if (error < search.least - slack ||
      (error < search.least + slack && distance < solver_.distance(search.best.theta, theta))) {
    search.best = {posture, error};
  }
  search.least = std::min(search.least, error);
  if (error > options_.tolerance_m) return used;
  ++search.solutions;
  IkApproach candidate{posture};
  double far = distance;
  for (size_t k = 0; k < search.nearest.size(); ++k) {
    if (!(far < search.distance[k])) continue;
    std::swap(candidate, search.nearest[k]);
    std::swap(far, search.distance[k]);
  }
  return used;
}

int MultiStartIk::continue_approach(IkSearch& search, int work) const {
  const LevenbergMarquardtIk& solver = solver_of(search);
  const JointVector theta = search.light ? solver_.clamped(search.theta) : search.theta;
  const auto k = static_cast<size_t>(search.approached);
  if (k == search.nearest.size() || !std::isfinite(search.distance[k])) {
    search.finished = !search.light || search.best.error_m <= options_.tolerance_m;
    if (!search.finished) begin_starts(false, search.theta, search);
    return 0;
  }
  IkApproach& run = search.nearest[k];
  const int used = solver.approach(search.target, theta, run, options_.tolerance_m, work);
  if (!run.finished) return used;
  if (search.approached == 0) search.least = std::numeric_limits<double>::infinity();  // from here on: the distance
  ++search.approached;
  const double distance = solver_.distance(run.posture, theta);
  if (distance < search.least) {
    search.least = distance;
    search.best = {run.posture, solver_.error(search.target, run.posture)};
  }
  return used + 1;
}

}  // namespace multireach::controller
