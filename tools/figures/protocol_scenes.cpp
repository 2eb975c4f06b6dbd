#include "tools/figures/protocol_scenes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "controller/posture_search.hpp"
#include "tools/figures/protocol_measures.hpp"
#include "tools/figures/protocol_run.hpp"

namespace multireach {
namespace {

// Their numbers, with lengths over 0.352 m, the iCub's arm from the shoulder to the palm. The middle is not theirs: it
// is where the tasks fit into the workspace of every arm here, straight before the shoulder.
constexpr int kReaches = 21, kLemniscatePoints = 1000, kLaps = 2;
constexpr double kReachSeconds = 9, kLemniscateSeconds = 300;
constexpr double kApart = 0.2287 / 0.352, kHalfWidth = 0.13 / 0.352, kForward = 0.6;
constexpr double kArrivalSeconds = 10;  // in which the hand comes to the curve; not counted
constexpr double kMinimumJerkSeconds = 1.5;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

JointVector middle_of(const Chain& chain) {
  JointVector theta(chain.size());
  for (int i = 0; i < chain.size(); ++i) theta[i] = 0.5 * (chain.sample_lower(i) + chain.sample_upper(i));
  return theta;
}

Eigen::Vector3d middle_place(const Chain& chain) {
  return chain.fixed(0).translation() + kForward * chain.reach() * Eigen::Vector3d::UnitX();
}

std::vector<ProtocolTarget> reaches(const Chain& chain) {
  const Eigen::Vector3d half =
      0.5 * kApart * chain.reach() * Eigen::Vector3d(0.032, 0.226, -0.013).normalized();  // between their two points
  std::vector<ProtocolTarget> targets;
  for (int k = 0; k < kReaches; ++k) {
    const Eigen::Vector3d place = middle_place(chain) + (k % 2 == 0 ? 1 : -1) * half;
    targets.push_back({.time_s = k * kReachSeconds, .position = place, .velocity = Eigen::Vector3d::Zero()});
  }
  return targets;
}

/// The lemniscate of Bernoulli in the plane of y and z, x = cos(u) / (1 + sin(u)^2), y = sin(u) x, by its length.
class Lemniscate {
 public:
  Lemniscate(const Eigen::Vector3d& middle, double half_width) : middle_(middle), half_width_(half_width) {
    // du/ds = sqrt(1 + sin(u)^2) from the crossing, for a half width of 1, by the rule of Runge and Kutta.
    const auto slope = [](double u) { return std::sqrt(1 + std::sin(u) * std::sin(u)); };
    double u = -std::numbers::pi / 2;
    for (int k = 0; k <= kPerLap; ++k) {
      u_.push_back(u);
      const double a = slope(u), b = slope(u + 0.5 * kStep * a), c = slope(u + 0.5 * kStep * b);
      u += kStep / 6 * (a + 2 * b + 2 * c + slope(u + kStep * c));
    }
  }
  double lap() const { return kLap * half_width_; }
  Eigen::Vector3d at(double length) const { return place(parameter(length)); }
  Eigen::Vector3d tangent(double length) const {
    const double u = parameter(length), small = 1e-5;
    return (place(u + small) - place(u - small)).normalized();
  }
  /// How far a point is from the curve.
  double distance(const Eigen::Vector3d& point) const {
    constexpr size_t kStride = 8;  // the curve is nowhere further from such a chord than 2e-6 of its half width
    double least = std::numeric_limits<double>::infinity();
    Eigen::Vector3d from = place(u_[0]);
    for (size_t k = kStride; k < u_.size(); k += kStride) {
      const Eigen::Vector3d to = place(u_[k]), chord = to - from;
      const double along = std::clamp((point - from).dot(chord) / chord.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (from + along * chord - point).norm());
      from = to;
    }
    return least;
  }

 private:
  static constexpr double kLap = 5.244115108584239;  // a lap's length for a half width of 1
  static constexpr int kPerLap = 20000;
  static constexpr double kStep = kLap / kPerLap;

  double parameter(double length) const {
    const double steps = std::fmod(length, lap()) / half_width_ / kStep;
    const auto k = std::min(static_cast<size_t>(steps), static_cast<size_t>(kPerLap - 1));
    return u_[k] + (steps - static_cast<double>(k)) * (u_[k + 1] - u_[k]);
  }
  Eigen::Vector3d place(double u) const {
    const double across = std::cos(u) / (1 + std::sin(u) * std::sin(u));
    return middle_ + half_width_ * Eigen::Vector3d(0, across, std::sin(u) * across);
  }

  Eigen::Vector3d middle_;
  double half_width_;
  std::vector<double> u_;
};

Lemniscate lemniscate(const Chain& chain) {
  return {middle_place(chain), kHalfWidth * chain.reach()};
}

double lemniscate_speed(const Lemniscate& curve) {
  return kLaps * curve.lap() / kLemniscateSeconds;
}

std::vector<ProtocolTarget> points_of(const Lemniscate& curve, bool velocity_told) {
  const double speed = lemniscate_speed(curve);
  std::vector<ProtocolTarget> targets;
  for (int k = 0; k < kLemniscatePoints; ++k) {
    const double time = kLemniscateSeconds * k / (kLemniscatePoints - 1), length = speed * time;
    const Eigen::Vector3d velocity = (velocity_told ? speed : 0) * curve.tangent(length);
    targets.push_back({.time_s = time, .position = curve.at(length), .velocity = velocity});
  }
  return targets;
}

/// Whether all targets are within reach, at an orientation or at any.
bool reaches_all(const Chain& chain, const std::vector<ProtocolTarget>& targets,
                 const std::optional<Eigen::Matrix3d>& orientation) {
  const controller::PostureSearch search(chain);
  JointVector posture = middle_of(chain);
  return std::all_of(targets.begin(), targets.end(), [&](const ProtocolTarget& target) {
    controller::HandTarget hand{.position = target.position};
    if (orientation) hand.aim = controller::Aim::kPose;
    if (orientation) hand.orientation = *orientation;
    const controller::FoundPosture found = search.best(hand, posture);
    posture = found.theta;
    return found.error_m <= search.options().tolerance_m;
  });
}

/// The laws that run a task with an arm, and the orientation for the one that takes it: what the hand has in the
/// middle of the task, reached from the middle of the joints' range.
struct Field {
  std::vector<ProtocolLaw> laws{ProtocolLaw::kGuarded, ProtocolLaw::kPaper, ProtocolLaw::kPaperLiteral,
                                ProtocolLaw::kDampedLeastSquares};
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();
};

Field field_for(const Chain& chain, const std::vector<ProtocolTarget>& targets) {
  if (!reaches_all(chain, targets, {})) {
    throw std::invalid_argument("the arm does not reach all points of this task");
  }
  Field field;
  const auto found = controller::PostureSearch(chain).best({.position = middle_place(chain)}, middle_of(chain));
  field.orientation = chain.pose(found.theta).linear();
  if (chain.size() >= 6 && reaches_all(chain, targets, field.orientation)) {
    field.laws.push_back(ProtocolLaw::kGuardedPose);
  }
  return field;
}

std::vector<ProtocolRun> all_runs(const Chain& chain, const Field& field, const std::vector<ProtocolTarget>& targets,
                                  double seconds) {
  std::vector<ProtocolRun> runs;
  for (const ProtocolLaw law : field.laws) {
    runs.push_back(run_protocol(chain, law, middle_of(chain), targets, seconds, field.orientation));
  }
  return runs;
}

/// How far the hand is turned from an orientation, rad.
double turned(const Chain& chain, const JointVector& theta, const Eigen::Matrix3d& orientation) {
  return Eigen::AngleAxisd(chain.pose(theta).linear().transpose() * orientation).angle();
}

/// Of the laws that take positions, for the pictures.
std::vector<ProtocolRun> position_runs(const Chain& chain, const std::vector<ProtocolTarget>& targets, double seconds) {
  if (!reaches_all(chain, targets, {})) {
    throw std::invalid_argument("the arm does not reach all points of this task");
  }
  return all_runs(chain, {}, targets, seconds);
}

size_t index_at(double seconds) {
  return static_cast<size_t>(std::llround(seconds / kProtocolTick));
}

/// The hand's place, or nothing after a run has ended.
Eigen::Vector3d hand_at(const ProtocolRun& run, size_t k) {
  return k < run.hand.size() ? run.hand[k] : Eigen::Vector3d::Constant(kNone);
}

struct LimitMeasures {
  double position_excess = 0, speed_part = 0;
};

LimitMeasures measure_limits(const Chain& chain, const ProtocolRun& run) {
  LimitMeasures measures;
  for (size_t k = 1; k < run.theta.size(); ++k) {
    measures.position_excess = std::max(measures.position_excess, chain.limit_excess(run.theta[k]));
    const Eigen::ArrayXd speed = (run.theta[k] - run.theta[k - 1]).array().abs() / kProtocolTick;
    measures.speed_part = std::max(measures.speed_part, (speed / chain.velocity().array()).maxCoeff());
  }
  return measures;
}

/// Of all reaches but the first, which only brings the hand to where the second begins.
std::vector<double> reach_measures(const Chain& chain, const ProtocolRun& run,
                                   const std::vector<ProtocolTarget>& targets, const Eigen::Matrix3d& orientation) {
  double most_turned = 0;
  std::vector<double> error, ratio, settled, jerk, peaks;
  for (size_t k = 1; k < targets.size(); ++k) {
    const size_t from = index_at(targets[k].time_s), to = from + index_at(kReachSeconds);
    if (to >= run.hand.size()) break;
    const ReachMeasures reach =
        measure_reach(std::span(run.hand).subspan(from, to - from + 1), targets[k].position, kProtocolTick);
    error.push_back(reach.error_m);
    ratio.push_back(reach.path_ratio);
    settled.push_back(reach.settled_s);
    jerk.push_back(reach.normalised_jerk);
    peaks.push_back(reach.speed_peaks);
    most_turned = std::max(most_turned, turned(chain, run.theta[to], orientation));
  }
  const LimitMeasures limits = measure_limits(chain, run);
  const size_t first = std::min(index_at(kReachSeconds), run.hand.size());
  return {static_cast<double>(error.size()),
          quantile_of(error, 0.5),
          quantile_of(error, 1),
          quantile_of(ratio, 0.5),
          quantile_of(ratio, 1),
          quantile_of(settled, 0.5),
          quantile_of(jerk, 0.5),
          quantile_of(peaks, 0.5),
          quantile_of(peaks, 1),
          rms_jerk(std::span(run.hand).subspan(first), kProtocolTick),
          rms_jerk(std::span(run.theta).subspan(first), kProtocolTick),
          limits.position_excess,
          limits.speed_part,
          most_turned};
}

/// The straight movement with the least jerk, sampled as the others are.
ProtocolRun minimum_jerk(const Chain& chain, const std::vector<ProtocolTarget>& targets, double seconds) {
  ProtocolRun run;
  for (int k = 0; k <= std::llround(seconds / kProtocolTick); ++k) {
    const double now = k * kProtocolTick;
    const auto reach = std::min(static_cast<size_t>((now + 1e-9) / kReachSeconds), targets.size() - 1);
    const Eigen::Vector3d& to = targets[reach].position;
    const Eigen::Vector3d& from = reach > 0 ? targets[reach - 1].position : to;
    const double t = std::min((now - targets[reach].time_s) / kMinimumJerkSeconds, 1.0);
    run.hand.push_back(from + t * t * t * (10 - 15 * t + 6 * t * t) * (to - from));
    run.theta.push_back(middle_of(chain));
  }
  return run;
}

struct TrackingMeasures {
  double rms_m = 0, most_m = 0, off_rms_m = 0, off_most_m = 0, seconds = 0, most_turned = 0;
};

TrackingMeasures measure_tracking(const Chain& chain, const Lemniscate& curve, const ProtocolRun& run,
                                  const Eigen::Matrix3d& orientation) {
  const double speed = lemniscate_speed(curve);
  TrackingMeasures measures;
  double squares = 0, off_squares = 0;
  int samples = 0;
  for (size_t k = index_at(kArrivalSeconds); k < run.hand.size(); ++k) {
    const double now = static_cast<double>(k) * kProtocolTick;
    const double apart = (run.hand[k] - curve.at(speed * now)).norm(), off = curve.distance(run.hand[k]);
    squares += apart * apart;
    off_squares += off * off;
    measures.most_m = std::max(measures.most_m, apart);
    measures.off_most_m = std::max(measures.off_most_m, off);
    measures.most_turned = std::max(measures.most_turned, turned(chain, run.theta[k], orientation));
    measures.seconds = now;
    ++samples;
  }
  measures.rms_m = std::sqrt(squares / samples);
  measures.off_rms_m = std::sqrt(off_squares / samples);
  return measures;
}

}  // namespace

Table protocol_reaches_scene(const Chain& chain) {
  const std::vector<ProtocolTarget> targets = reaches(chain);
  const double seconds = kReaches * kReachSeconds;
  const std::vector<ProtocolRun> runs = position_runs(chain, targets, seconds);
  Table table({"time", "distance_0", "speed_0", "distance_1", "speed_1", "distance_2", "speed_2", "distance_3",
               "speed_3", "along_0", "aside_0", "along_1", "aside_1", "along_2", "aside_2", "along_3", "aside_3"});
  const Eigen::Vector3d there = targets[0].position, line = (targets[1].position - there).normalized();
  const size_t from = index_at((kReaches - 2) * kReachSeconds);
  for (size_t k = from; k <= index_at(seconds); ++k) {
    const double now = static_cast<double>(k) * kProtocolTick;
    const auto reach = std::min(static_cast<size_t>((now + 1e-9) / kReachSeconds), targets.size() - 1);
    std::vector<double> row{static_cast<double>(k - from) * kProtocolTick};
    for (const ProtocolRun& run : runs) {
      row.push_back((hand_at(run, k) - targets[reach].position).norm());
      row.push_back((hand_at(run, k) - hand_at(run, k - 1)).norm() / kProtocolTick);
    }
    for (const ProtocolRun& run : runs) {
      const Eigen::Vector3d way = hand_at(run, k) - there;
      row.push_back(way.dot(line));
      row.push_back((way - way.dot(line) * line).norm());
    }
    table.row(row);
  }
  return table;
}

Table protocol_reaches_measures_scene(const Chain& chain) {
  const std::vector<ProtocolTarget> targets = reaches(chain);
  const Field field = field_for(chain, targets);
  const double seconds = kReaches * kReachSeconds;
  Table table({"law", "reaches", "error_p50", "error_max", "path_ratio_p50", "path_ratio_max", "settled_p50",
               "normalised_jerk_p50", "speed_peaks_p50", "speed_peaks_max", "hand_jerk_rms", "joint_jerk_rms",
               "limit_excess", "speed_part", "turned_max"});
  const auto row = [&](double law, const ProtocolRun& run) {
    std::vector<double> values = reach_measures(chain, run, targets, field.orientation);
    values.insert(values.begin(), law);
    table.row(values);
  };
  const std::vector<ProtocolRun> runs = all_runs(chain, field, targets, seconds);
  for (size_t k = 0; k < runs.size(); ++k) row(static_cast<double>(field.laws[k]), runs[k]);
  row(-1, minimum_jerk(chain, targets, seconds));
  return table;
}

Table protocol_lemniscate_scene(const Chain& chain) {
  const Lemniscate curve = lemniscate(chain);
  const std::vector<ProtocolRun> untold = position_runs(chain, points_of(curve, false), kLemniscateSeconds);
  const std::vector<ProtocolRun> told = position_runs(chain, points_of(curve, true), kLemniscateSeconds);
  Table table({"time", "target_y", "target_z", "y_0", "z_0", "y_1", "z_1", "y_2", "z_2", "y_3", "z_3", "untold_0",
               "untold_1", "untold_2", "untold_3", "told_0", "told_1", "told_2", "told_3"});
  constexpr size_t kEvery = 8;
  for (size_t k = 0; k <= index_at(kLemniscateSeconds); k += kEvery) {
    const double now = static_cast<double>(k) * kProtocolTick;
    const Eigen::Vector3d target = curve.at(lemniscate_speed(curve) * now);
    std::vector<double> row{now, target.y(), target.z()};
    for (const ProtocolRun& run : untold) {
      row.push_back(hand_at(run, k).y());
      row.push_back(hand_at(run, k).z());
    }
    for (const auto* runs : {&untold, &told}) {
      for (const ProtocolRun& run : *runs) row.push_back((hand_at(run, k) - target).norm());
    }
    table.row(row);
  }
  return table;
}

Table protocol_lemniscate_measures_scene(const Chain& chain) {
  const Lemniscate curve = lemniscate(chain);
  const Field field = field_for(chain, points_of(curve, false));
  Table table({"law", "told", "seconds", "error_rms", "error_max", "off_curve_rms", "off_curve_max", "path_ratio",
               "hand_jerk_rms", "joint_jerk_rms", "limit_excess", "speed_part", "turned_max"});
  for (const bool told : {false, true}) {
    const std::vector<ProtocolRun> runs = all_runs(chain, field, points_of(curve, told), kLemniscateSeconds);
    for (size_t k = 0; k < runs.size(); ++k) {
      const ProtocolRun& run = runs[k];
      const TrackingMeasures tracking = measure_tracking(chain, curve, run, field.orientation);
      const LimitMeasures limits = measure_limits(chain, run);
      const size_t first = std::min(index_at(kArrivalSeconds), run.hand.size());
      double length = 0;
      for (size_t i = first + 1; i < run.hand.size(); ++i) length += (run.hand[i] - run.hand[i - 1]).norm();
      const double way = lemniscate_speed(curve) * (tracking.seconds - kArrivalSeconds);
      table.row({static_cast<double>(field.laws[k]), told ? 1.0 : 0.0, tracking.seconds, tracking.rms_m,
                 tracking.most_m, tracking.off_rms_m, tracking.off_most_m, length / way,
                 rms_jerk(std::span(run.hand).subspan(first), kProtocolTick),
                 rms_jerk(std::span(run.theta).subspan(first), kProtocolTick), limits.position_excess,
                 limits.speed_part, tracking.most_turned});
    }
  }
  return table;
}

}  // namespace multireach
