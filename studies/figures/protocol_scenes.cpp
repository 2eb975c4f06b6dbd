// The two tasks of Pattacini et al.; see scenes.hpp.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "controller/ik/multi_start.hpp"
#include "studies/figures/protocol_run.hpp"
#include "studies/figures/scenes.hpp"

namespace multireach {
namespace {

// The numbers of Pattacini et al., with lengths divided by 0.352 m, the iCub's arm length from shoulder to palm. The
// centre of the tasks is not theirs: it lies straight in front of the shoulder, where the tasks fit the workspace of
// every arm here.
constexpr int kReaches = 21, kLemniscatePoints = 1000, kLaps = 2;
constexpr double kReachSeconds = 9, kLemniscateSeconds = 300;
constexpr double kApart = 0.2287 / 0.352, kHalfWidth = 0.13 / 0.352, kForward = 0.6;
constexpr double kArrivalSeconds = 10;  // time for the hand to reach the curve; not evaluated
constexpr double kMinimumJerkSeconds = 1.5;
constexpr double kSettled = 0.01;    // fraction of the distance
constexpr size_t kPositionLaws = 4;  // the first laws of a Field; the figures show these
constexpr double kDegrees = 180 / std::numbers::pi;
const char* const kHandJerk = "jerk of the hand; RMS";
const char* const kTurned = "hand turned by at most";
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

JointVector middle_of(const Chain& chain) {
  JointVector theta(chain.size());
  for (int i = 0; i < chain.size(); ++i) theta[i] = 0.5 * (chain.sample_lower(i) + chain.sample_upper(i));
  return theta;
}

Eigen::Vector3d task_centre(const Chain& chain) {
  return chain.fixed(0).translation() + kForward * chain.reach() * Eigen::Vector3d::UnitX();
}

std::vector<ProtocolTarget> reaches(const Chain& chain) {
  const Eigen::Vector3d half =
      0.5 * kApart * chain.reach() * Eigen::Vector3d(0.032, 0.226, -0.013).normalized();  // between their two points
  std::vector<ProtocolTarget> targets;
  for (int k = 0; k < kReaches; ++k) {
    const Eigen::Vector3d centre = task_centre(chain) + (k % 2 == 0 ? 1 : -1) * half;
    targets.push_back({.time_s = k * kReachSeconds, .position = centre, .velocity = Eigen::Vector3d::Zero()});
  }
  return targets;
}

/// The lemniscate of Bernoulli in the y-z plane of W, x = cos(u) / (1 + sin(u)^2), y = sin(u) x, parametrised by arc
/// length.
class Lemniscate {
 public:
  Lemniscate(const Eigen::Vector3d& middle, double half_width) : middle_(middle), half_width_(half_width) {
    // Integrate du/ds = sqrt(1 + sin(u)^2) from the crossing, for a half width of 1, by the Runge-Kutta method.
    const auto slope = [](double u) { return std::sqrt(1 + std::sin(u) * std::sin(u)); };
    double u = -std::numbers::pi / 2;
    for (int k = 0; k <= kPerLap; ++k) {
      u_.push_back(u);
      const double a = slope(u), b = slope(u + 0.5 * kStep * a), c = slope(u + 0.5 * kStep * b);
      u += kStep / 6 * (a + 2 * b + 2 * c + slope(u + kStep * c));
    }
  }
  double lap() const { return kLap * half_width_; }
  Eigen::Vector3d at(double length) const { return point_at(parameter(length)); }
  Eigen::Vector3d tangent(double length) const {
    const double u = parameter(length), small = 1e-5;
    return (point_at(u + small) - point_at(u - small)).normalized();
  }
  /// The distance of a point from the curve.
  double distance(const Eigen::Vector3d& point) const {
    constexpr size_t kStride = 8;  // such chords deviate from the curve by at most 2e-6 of its half width
    double least = std::numeric_limits<double>::infinity();
    Eigen::Vector3d from = point_at(u_[0]);
    for (size_t k = kStride; k < u_.size(); k += kStride) {
      const Eigen::Vector3d to = point_at(u_[k]), chord = to - from;
      const double along = std::clamp((point - from).dot(chord) / chord.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (from + along * chord - point).norm());
      from = to;
    }
    return least;
  }

 private:
  static constexpr double kLap = 5.244115108584239;  // length of a lap for a half width of 1
  static constexpr int kPerLap = 20000;
  static constexpr double kStep = kLap / kPerLap;

  double parameter(double length) const {
    const double steps = std::fmod(length, lap()) / half_width_ / kStep;
    const auto k = std::min(static_cast<size_t>(steps), static_cast<size_t>(kPerLap - 1));
    return u_[k] + (steps - static_cast<double>(k)) * (u_[k + 1] - u_[k]);
  }
  Eigen::Vector3d point_at(double u) const {
    const double across = std::cos(u) / (1 + std::sin(u) * std::sin(u));
    return middle_ + half_width_ * Eigen::Vector3d(0, across, std::sin(u) * across);
  }

  Eigen::Vector3d middle_;
  double half_width_;
  std::vector<double> u_;
};

Lemniscate lemniscate(const Chain& chain) {
  return {task_centre(chain), kHalfWidth * chain.reach()};
}

double lemniscate_speed(const Lemniscate& curve) {
  return kLaps * curve.lap() / kLemniscateSeconds;
}

std::vector<ProtocolTarget> points_of(const Lemniscate& curve, bool with_velocity) {
  const double speed = lemniscate_speed(curve);
  std::vector<ProtocolTarget> targets;
  for (int k = 0; k < kLemniscatePoints; ++k) {
    const double time = kLemniscateSeconds * k / (kLemniscatePoints - 1), length = speed * time;
    const Eigen::Vector3d velocity = (with_velocity ? speed : 0) * curve.tangent(length);
    targets.push_back({.time_s = time, .position = curve.at(length), .velocity = velocity});
  }
  return targets;
}

/// Whether all targets are reachable, with the given orientation if there is one.
bool reaches_all(const Chain& chain, const std::vector<ProtocolTarget>& targets,
                 const std::optional<Eigen::Matrix3d>& orientation) {
  const controller::MultiStartIk search(chain);
  JointVector posture = middle_of(chain);
  return std::all_of(targets.begin(), targets.end(), [&](const ProtocolTarget& target) {
    controller::TaskTarget hand{.position = target.position};
    if (orientation) hand.task = controller::TaskKind::kPose;
    if (orientation) hand.orientation = *orientation;
    const controller::IkSolution found = search.best(hand, posture);
    posture = found.theta;
    return found.error_m <= search.options().tolerance_m;
  });
}

/// The laws compared on a task, and the orientation for kGuardedPose: that of the hand at the centre of the task,
/// reached from the middle of the joints' ranges.
struct ComparedLaws {
  std::vector<ProtocolLaw> laws{ProtocolLaw::kGuarded, ProtocolLaw::kPaper, ProtocolLaw::kPaperLiteral,
                                ProtocolLaw::kDampedLeastSquares};
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();
};

ComparedLaws compared_laws(const Chain& chain, const std::vector<ProtocolTarget>& targets) {
  if (!reaches_all(chain, targets, {})) {
    throw std::invalid_argument("the arm does not reach all points of this task");
  }
  ComparedLaws compared;
  const auto found = controller::MultiStartIk(chain).best({.position = task_centre(chain)}, middle_of(chain));
  compared.orientation = chain.pose(found.theta).linear();
  if (chain.size() >= 6 && reaches_all(chain, targets, compared.orientation)) {
    compared.laws.push_back(ProtocolLaw::kGuardedPose);
  }
  return compared;
}

std::vector<ProtocolRun> all_runs(const Chain& chain, const ComparedLaws& compared,
                                  const std::vector<ProtocolTarget>& targets, double seconds) {
  std::vector<ProtocolRun> runs;
  for (const ProtocolLaw law : compared.laws) {
    runs.push_back(run_protocol(chain, law, middle_of(chain), targets, seconds, compared.orientation));
  }
  return runs;
}

/// The angle between the hand's orientation and a given one, rad.
double turned(const Chain& chain, const JointVector& theta, const Eigen::Matrix3d& orientation) {
  return Eigen::AngleAxisd(chain.pose(theta).linear().transpose() * orientation).angle();
}

/// The index of the reach at time `now`.
size_t reach_at(const std::vector<ProtocolTarget>& targets, double now) {
  return std::min(static_cast<size_t>((now + 1e-9) / kReachSeconds), targets.size() - 1);
}

size_t index_at(double seconds) {
  return static_cast<size_t>(std::llround(seconds / kProtocolTick));
}

/// Set-point k; NaN positions after the end of the run.
Moment moment_of(const ProtocolRun& run, size_t k) {
  if (k < run.motion.size()) return run.motion[k];
  const Eigen::Vector3d nothing = Eigen::Vector3d::Constant(kNone);
  return {.theta = {}, .velocity = {}, .theta_target = {}, .x = nothing, .x_dot = nothing};
}

std::string name_of(ProtocolLaw law) {
  switch (law) {
    case ProtocolLaw::kGuarded:
      return "guarded";
    case ProtocolLaw::kPaper:
      return "paper";
    case ProtocolLaw::kPaperLiteral:
      return "paper; literal";
    case ProtocolLaw::kDampedLeastSquares:
      return "damped least squares";
    case ProtocolLaw::kGuardedPose:
      return "guarded; orientation held";
  }
  return {};
}

double median(std::vector<double> values) {
  if (values.empty()) return kNone;
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() - 1) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

double largest(const std::vector<double>& values) {
  return values.empty() ? kNone : std::ranges::max(values);
}

/// Adds the measures of a whole run; jerk is measured from the time `from` on.
void add_run_measures(Figure& figure, const std::string& law, const Chain& chain, const ProtocolRun& run, double from) {
  const Motion counted = part(run.motion, from, run.motion.back().time);
  double excess = 0, speed = 0;
  for (const Moment& moment : run.motion) {
    excess = std::max(excess, chain.limit_excess(moment.theta));
    speed = std::max(speed, (moment.velocity.array().abs() / chain.velocity().array()).maxCoeff());
  }
  figure.add(law, kHandJerk, hand_jerk(counted), "m/s³");
  figure.add(law, "jerk of the joints; RMS", joint_jerk(counted), "rad/s³");
  figure.add(law, "farthest beyond a limit", excess * kDegrees, "°");
  figure.add(law, "largest joint speed / its limit", speed);
  if (!run.finite) figure.add(law, "not finite after", run.motion.back().time, "s");
}

/// Adds the measures of all reaches except the first, which only brings the hand to the start of the second.
void add_reaches(Figure& figure, const std::string& law, const Motion& motion,
                 const std::vector<ProtocolTarget>& targets) {
  std::vector<double> error, ratio, settled, jerk, peaks;
  for (size_t k = 1; k < targets.size(); ++k) {
    const double from = targets[k].time_s, to = from + kReachSeconds;
    if (to > motion.back().time + kProtocolTick / 2) break;
    const Motion reach = part(motion, from, to);
    const double distance = (targets[k].position - reach.front().x).norm();
    const double after = settled_after(reach, targets[k].position, kSettled * distance);
    const double until = std::isnan(after) ? to : after;
    error.push_back(1e3 * (targets[k].position - reach.back().x).norm());
    ratio.push_back(straightness(reach));
    settled.push_back(until - from);
    jerk.push_back(normalised_jerk(part(reach, from, until)));
    peaks.push_back(speed_peaks(reach));
  }
  figure.add(law, "reaches", static_cast<double>(error.size()));
  figure.add(law, "hand to target at the end; median", median(error), "mm");
  figure.add(law, "hand to target at the end; worst", largest(error), "mm");
  figure.add(law, "path / distance; median", median(ratio));
  figure.add(law, "path / distance; worst", largest(ratio));
  figure.add(law, "within 1 % for good after; median", median(settled), "s");
  figure.add(law, "normalised jerk; median", median(jerk));
  figure.add(law, "most maxima of the hand speed", largest(peaks));
}

/// The largest angle (rad) between the hand's orientation and a given one, sampled every `every` seconds from `from`
/// on.
double most_turned(const Chain& chain, const Motion& motion, const Eigen::Matrix3d& orientation, double from,
                   double every) {
  double most = 0;
  for (size_t k = index_at(from); k < motion.size(); k += index_at(every)) {
    most = std::max(most, turned(chain, motion[k].theta, orientation));
  }
  return most;
}

/// Straight minimum-jerk movements, sampled like the others; hand motion only, without joints.
Motion minimum_jerk(const std::vector<ProtocolTarget>& targets, double seconds) {
  Motion motion;
  for (int k = 0; k <= std::llround(seconds / kProtocolTick); ++k) {
    const double now = k * kProtocolTick;
    const size_t reach = reach_at(targets, now);
    const Eigen::Vector3d& to = targets[reach].position;
    const Eigen::Vector3d& from = reach > 0 ? targets[reach - 1].position : to;
    const double t = std::min((now - targets[reach].time_s) / kMinimumJerkSeconds, 1.0);
    append_setpoint(motion, kProtocolTick, JointVector(), from + t * t * t * (10 - 15 * t + 6 * t * t) * (to - from));
  }
  return motion;
}

/// Adds the tracking errors of a run, measured after kArrivalSeconds.
void add_tracking(Figure& figure, const std::string& law, const Lemniscate& curve, const ProtocolRun& run) {
  const double speed = lemniscate_speed(curve);
  const Motion counted = part(run.motion, kArrivalSeconds, kLemniscateSeconds);
  double squares = 0, off_squares = 0, most = 0, off_most = 0;
  for (const Moment& moment : counted) {
    const double apart = (moment.x - curve.at(speed * moment.time)).norm(), off = curve.distance(moment.x);
    squares += apart * apart;
    off_squares += off * off;
    most = std::max(most, apart);
    off_most = std::max(off_most, off);
  }
  const auto samples = static_cast<double>(counted.size());
  figure.add(law, "hand to target; RMS", 1e3 * std::sqrt(squares / samples), "mm");
  figure.add(law, "hand to target; worst", 1e3 * most, "mm");
  figure.add(law, "hand to curve; RMS", 1e3 * std::sqrt(off_squares / samples), "mm");
  figure.add(law, "hand to curve; worst", 1e3 * off_most, "mm");
  figure.add(law, "path / curve", path_length(counted) / (speed * (counted.back().time - counted.front().time)));
}

}  // namespace

Figure protocol_reaches_scene(const SceneArm& arm) {
  const Chain& chain = arm.chain;
  const std::vector<ProtocolTarget> targets = reaches(chain);
  const ComparedLaws compared = compared_laws(chain, targets);
  const double seconds = kReaches * kReachSeconds;
  const std::vector<ProtocolRun> runs = all_runs(chain, compared, targets, seconds);
  Figure figure{
      Table({"time", "distance_0", "speed_0", "distance_1", "speed_1", "distance_2", "speed_2", "distance_3", "speed_3",
             "along_0", "aside_0", "along_1", "aside_1", "along_2", "aside_2", "along_3", "aside_3"})};
  const Eigen::Vector3d there = targets[0].position, line = (targets[1].position - there).normalized();
  const size_t from = index_at((kReaches - 2) * kReachSeconds);
  for (size_t k = from; k <= index_at(seconds); ++k) {
    const size_t reach = reach_at(targets, static_cast<double>(k) * kProtocolTick);
    std::vector<double> row{static_cast<double>(k - from) * kProtocolTick};
    for (size_t law = 0; law < kPositionLaws; ++law) {
      const Moment moment = moment_of(runs[law], k);
      row.push_back((moment.x - targets[reach].position).norm());
      row.push_back(moment.x_dot.norm());
    }
    for (size_t law = 0; law < kPositionLaws; ++law) {
      const Eigen::Vector3d way = moment_of(runs[law], k).x - there;
      row.push_back(way.dot(line));
      row.push_back((way - way.dot(line) * line).norm());
    }
    figure.curves.row(row);
  }
  for (size_t k = 0; k < runs.size(); ++k) {
    const std::string law = name_of(compared.laws[k]);
    add_reaches(figure, law, runs[k].motion, targets);
    add_run_measures(figure, law, chain, runs[k], kReachSeconds);
    if (compared.laws[k] != ProtocolLaw::kGuardedPose) continue;
    figure.add(law, kTurned,
               kDegrees * most_turned(chain, runs[k].motion, compared.orientation, 2 * kReachSeconds, kReachSeconds),
               "°");
  }
  const Motion ideal = minimum_jerk(targets, seconds);
  add_reaches(figure, "minimum jerk; 1.5 s", ideal, targets);
  figure.add("minimum jerk; 1.5 s", kHandJerk, hand_jerk(part(ideal, kReachSeconds, seconds)), "m/s³");
  return figure;
}

Figure protocol_lemniscate_scene(const SceneArm& arm) {
  const Chain& chain = arm.chain;
  const Lemniscate curve = lemniscate(chain);
  const ComparedLaws compared = compared_laws(chain, points_of(curve, false));
  std::array<std::vector<ProtocolRun>, 2> runs;  // without and with the target's velocity
  for (const bool with_velocity : {false, true}) {
    runs[with_velocity] = all_runs(chain, compared, points_of(curve, with_velocity), kLemniscateSeconds);
  }
  Figure figure{Table({"time", "target_y", "target_z", "y_0", "z_0", "y_1", "z_1", "y_2", "z_2", "y_3", "z_3",
                       "untold_0", "untold_1", "untold_2", "untold_3", "told_0", "told_1", "told_2", "told_3"})};
  constexpr size_t kEvery = 8;
  for (size_t k = 0; k <= index_at(kLemniscateSeconds); k += kEvery) {
    const double now = static_cast<double>(k) * kProtocolTick;
    const Eigen::Vector3d target = curve.at(lemniscate_speed(curve) * now);
    std::vector<double> row{now, target.y(), target.z()};
    for (size_t law = 0; law < kPositionLaws; ++law) {
      const Moment moment = moment_of(runs[0][law], k);
      row.push_back(moment.x.y());
      row.push_back(moment.x.z());
    }
    for (const std::vector<ProtocolRun>& way : runs) {
      for (size_t law = 0; law < kPositionLaws; ++law) row.push_back((moment_of(way[law], k).x - target).norm());
    }
    figure.curves.row(row);
  }
  for (const bool with_velocity : {false, true}) {
    for (size_t k = 0; k < runs[with_velocity].size(); ++k) {
      const std::string law = name_of(compared.laws[k]) + (with_velocity ? "; velocity told" : "");
      const ProtocolRun& run = runs[with_velocity][k];
      add_tracking(figure, law, curve, run);
      add_run_measures(figure, law, chain, run, kArrivalSeconds);
      if (compared.laws[k] != ProtocolLaw::kGuardedPose) continue;
      figure.add(law, kTurned,
                 kDegrees * most_turned(chain, run.motion, compared.orientation, kArrivalSeconds, kProtocolTick), "°");
    }
  }
  return figure;
}

}  // namespace multireach
