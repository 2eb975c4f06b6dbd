#include "studies/tracking/tracking.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "controller/reach_controller.hpp"
#include "controller/tracking_defaults.hpp"
#include "kinematics/default_limits.hpp"
#include "studies/joint_motion.hpp"
#include "studies/quantiles.hpp"

namespace multireach {
namespace {

using controller::ReachController;
using nlohmann::json;

constexpr int64_t kObservationUs = 33333;                         // 30 Hz
constexpr double kLatency = 1e-6 * controller::kTrackPrediction;  // s: from the image to the motion
constexpr double kApproach = 4;                                   // s: until the hand is with the target
constexpr double kMeasured = 4;                                   // s
constexpr double kFollowerGain = 20, kFollowerDamping = 0.01;     // 1/s; of the arm's reach
constexpr double kFollowerPeriod = 1.0 / 140;                     // s: an integration step of the controller
constexpr double kLagFrom = -0.2, kLagTo = 0.5;                   // s

struct Observation {
  Eigen::Vector3d position, velocity;
};

/// The controller's set-points, each reached at the end of its tick, kLatency late.
JointMotion run_controller(const Chain& chain, const JointVector& start, Tracker tracker, double end,
                           const auto& observation_at) {
  controller::ReachOptions options;
  if (tracker == Tracker::kTrack) {
    controller::GuardedParameters law;
    law.gains = controller::kTrackGains;
    options.law = law;
    options.prediction_us = controller::kTrackPrediction;
    options.target.acceleration_s = controller::kTrackAccelerationTime;
    options.target.jerk_noise_m2_s5 = controller::kTrackJerkNoise;
  }
  ReachController reach(chain, options);
  reach.start(start);
  reach.restart_grid(0);
  std::vector<Knot> knots{{0, start, JointVector::Zero(chain.size())}};
  for (int64_t now = 0; 1e-6 * static_cast<double>(now) < end; now += kObservationUs) {
    const Observation seen = observation_at(1e-6 * static_cast<double>(now));
    reach.observe({.utime = now, .seen = true, .position = seen.position, .velocity = seen.velocity});
    while (*reach.next_tick() <= now) {
      const controller::ReachOutput out = reach.tick();
      knots.push_back({1e-6 * static_cast<double>(out.utime + options.tick_us) + kLatency, out.theta, out.velocity});
    }
  }
  return sampled_motion(knots, end);
}

/// One velocity for each joint, by damped least squares, within the limits of speed and acceleration.
JointMotion run_follower(const Chain& chain, const JointVector& start, double end, const auto& observation_at) {
  const JointVector most = chain.velocity().cwiseMin(kSpeedWhereUnlimited), acceleration = default_acceleration(most);
  const double damping = kFollowerDamping * chain.reach();
  Knot knot{0, start, JointVector::Zero(chain.size())};
  std::vector<Knot> knots{knot};
  Eigen::Vector3d x;
  PositionJacobian J;
  while (knot.time < end) {
    // The newest observation of the images that have arrived, extrapolated to when the robot is here.
    const double taken = std::floor((knot.time - kLatency) * 1e6 / kObservationUs) * 1e-6 * kObservationUs;
    const Observation seen = observation_at(std::max(taken, 0.0));
    chain.position_and_jacobian(knot.theta, x, J);
    const Eigen::Vector3d target = seen.position + (knot.time - taken) * seen.velocity;
    const Eigen::Matrix3d A = J * J.transpose() + damping * damping * Eigen::Matrix3d::Identity();
    JointVector wanted = J.transpose() * A.ldlt().solve(seen.velocity + kFollowerGain * (target - x));
    const double over = wanted.cwiseAbs().cwiseQuotient(most).maxCoeff();
    if (over > 1) wanted /= over;
    const JointVector change = kFollowerPeriod * acceleration;
    wanted = wanted.cwiseMax(knot.velocity - change).cwiseMin(knot.velocity + change);
    const JointVector next = chain.clamped(knot.theta + kFollowerPeriod * wanted);
    knot = {knot.time + kFollowerPeriod, next, (next - knot.theta) / kFollowerPeriod};
    knots.push_back(knot);
  }
  return sampled_motion(knots, end);
}

double rms(const std::vector<Eigen::Vector3d>& hand, double from, const auto& target_at) {
  double sum = 0;
  for (size_t k = 0; k < hand.size(); ++k)
    sum += (hand[k] - target_at(from + kMotionSampling * static_cast<double>(k))).squaredNorm();
  return std::sqrt(sum / static_cast<double>(hand.size()));
}

struct NamedTracker {
  Tracker tracker;
  const char* name;
};
constexpr std::array kTrackers{NamedTracker{Tracker::kReach, "motion: reach"},
                               NamedTracker{Tracker::kTrack, "motion: track"},
                               NamedTracker{Tracker::kFollower, "follower"}};

const std::array<TrackedPath, 3>& tracked_paths() {
  static const std::array<TrackedPath, 3> paths{
      {{"circle, 2 s", 2, false}, {"circle, 0.5 s", 0.5, false}, {"figure 8, 2 s", 2, true}}};
  return paths;
}

}  // namespace

Eigen::Vector3d TrackedPath::position(double t, double radius) const {
  const double angle = 2 * std::numbers::pi * t / period_s;
  if (eight) return {radius * std::sin(angle), radius * std::sin(2 * angle) / 2, 0};
  return {radius * std::cos(angle), radius * std::sin(angle), 0};
}

Eigen::Vector3d TrackedPath::velocity(double t, double radius) const {
  const double w = 2 * std::numbers::pi / period_s, angle = w * t;
  if (eight) return {radius * w * std::cos(angle), radius * w * std::cos(2 * angle), 0};
  return {-radius * w * std::sin(angle), radius * w * std::cos(angle), 0};
}

std::optional<TrackingError> run_tracking(const Chain& chain, const JointVector& start, const TrackedPath& path,
                                          double radius_m, Tracker tracker, bool knows_velocity) {
  const Eigen::Vector3d centre = chain.position(start);
  const auto target_at = [&](double t) -> Eigen::Vector3d { return centre + path.position(t, radius_m); };
  controller::GuardedLaw law(chain);
  law.start(start);
  for (int k = 0; k < 16; ++k) {
    if (law.set_target({.position = target_at(k * path.period_s / 16)}) == controller::TargetResult::kUnreachable)
      return std::nullopt;
  }
  const auto observation_at = [&](double t) -> Observation {
    return {target_at(t), knows_velocity ? path.velocity(t, radius_m) : Eigen::Vector3d::Zero()};
  };
  const double end = kApproach + kMeasured;
  const JointMotion joints = tracker == Tracker::kFollower ? run_follower(chain, start, end, observation_at)
                                                           : run_controller(chain, start, tracker, end, observation_at);
  std::vector<Eigen::Vector3d> hand;
  const auto first = static_cast<size_t>(std::lround(kApproach / kMotionSampling));
  for (size_t k = first; k < joints.size(); ++k) hand.push_back(chain.position(joints[k]));
  const double from = kMotionSampling * static_cast<double>(first);
  TrackingError error{.rms_m = rms(hand, from, target_at)};
  for (size_t k = 0; k < hand.size(); ++k)
    error.max_m = std::max(error.max_m, (hand[k] - target_at(from + kMotionSampling * static_cast<double>(k))).norm());
  double least = std::numeric_limits<double>::infinity();
  const double latest = std::min(kLagTo, path.period_s / 2), earliest = std::max(kLagFrom, -path.period_s / 2);
  for (double lag = earliest; lag <= latest; lag += kMotionSampling) {
    const double rest = rms(hand, from - lag, target_at);
    if (rest >= least) continue;
    least = rest;
    error.lag_s = lag;
  }
  return error;
}

json run_tracking_study(const Chain& chain, const ReachSampler& sampler, int64_t samples, double radius_m) {
  json result{{"radius_m", radius_m}, {"places", samples}, {"rows", json::array()}};
  std::vector<JointVector> places;
  constexpr uint64_t kTries = 100;
  for (uint64_t k = 0; places.size() < static_cast<size_t>(samples) && k < kTries * static_cast<uint64_t>(samples);
       ++k) {
    const JointVector place = sampler.sample(k).target_posture;
    const bool reachable = std::ranges::all_of(tracked_paths(), [&](const TrackedPath& path) {
      return run_tracking(chain, place, path, radius_m, Tracker::kFollower, true).has_value();
    });
    if (reachable) places.push_back(place);
  }
  result["places"] = places.size();
  if (places.empty()) return result;
  for (const TrackedPath& path : tracked_paths()) {
    for (const bool knows_velocity : {false, true}) {
      for (const NamedTracker& one : kTrackers) {
        std::vector<double> errors, worst, lags;
        for (const JointVector& place : places) {
          const auto error = run_tracking(chain, place, path, radius_m, one.tracker, knows_velocity);
          errors.push_back(error->rms_m);
          worst.push_back(error->max_m);
          lags.push_back(error->lag_s);
        }
        result["rows"].push_back({{"path", path.name},
                                  {"knows_velocity", knows_velocity},
                                  {"tracker", one.name},
                                  {"rms_m", quantiles(errors)},
                                  {"max_m", quantiles(worst)},
                                  {"lag_s", quantiles(lags)}});
      }
    }
  }
  return result;
}

std::string tracking_table(const json& result) {
  std::string table =
      "| path | TARGET has | | rms error, mm: p50 | p95 | largest error, mm: p50 | p95 | lag, ms: p50 | p95 |\n"
      "|---|---|---|---|---|---|---|---|---|\n";
  for (const json& row : result.at("rows")) {
    table += fmt::format("| {} | {} | {} |", row.at("path").get<std::string>(),
                         row.at("knows_velocity").get<bool>() ? "velocity" : "position",
                         row.at("tracker").get<std::string>());
    for (const char* key : {"rms_m", "max_m", "lag_s"}) {
      for (const char* p : {"p50", "p95"})
        table += fmt::format(" {:.{}f} |", 1000 * row.at(key).at(p).get<double>(), key[0] == 'l' ? 0 : 1);
    }
    table += "\n";
  }
  return table;
}

}  // namespace multireach
