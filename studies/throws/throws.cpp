#include "studies/throws/throws.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "controller/ik/multi_start.hpp"
#include "controller/intercept/least_time.hpp"
#include "controller/reach_controller.hpp"
#include "controller/tracking_defaults.hpp"
#include "kinematics/default_limits.hpp"
#include "numeric/gaussian.hpp"
#include "numeric/random.hpp"
#include "studies/joint_motion.hpp"
#include "studies/quantiles.hpp"

namespace multireach {
namespace {

using controller::ReachController;
using nlohmann::json;

const Eigen::Vector3d kGravity(0, 0, -9.81);
constexpr int64_t kImageUs = 33333;                               // 30 Hz
constexpr int kFirstKnown = 2;                                    // fewer images after the first show no acceleration
constexpr double kLatency = 1e-6 * controller::kTrackPrediction;  // s: from the image to the motion
constexpr double kAfter = 0.3;                                    // s: after the flight, until the throw is over
constexpr double kPathStep = 0.01;                                // s: of the times at which the hand could be there
constexpr uint64_t kStreams = 3;  // of the random numbers of a throw: the throw itself, the noise, the solutions tried
constexpr double kDragStep = 0.001;  // s
constexpr int kSolutions = 8;        // of inverse kinematics, for each position of the path

CounterRandom random_of(uint64_t seed, uint64_t index, uint64_t stream) {
  return CounterRandom(seed, kStreams * index + stream);
}

JointVector uniform_posture(const Chain& chain, const CounterRandom& random, uint64_t& counter) {
  JointVector theta(chain.size());
  for (int i = 0; i < chain.size(); ++i)
    theta[i] = random.uniform(counter++, chain.sample_lower(i), chain.sample_upper(i));
  return theta;
}

/// Positions at times in steps of kDragStep, with the air's drag.
std::vector<Eigen::Vector3d> flight_path(const Throw& thrown, double drag, double end) {
  std::vector<Eigen::Vector3d> path;
  Eigen::Vector3d p = thrown.release, v = thrown.velocity;
  for (double t = 0; t < end; t += kDragStep) {
    path.push_back(drag > 0 ? p : thrown.position(t));
    // The midpoint rule.
    const auto acceleration = [&](const Eigen::Vector3d& speed) -> Eigen::Vector3d {
      return kGravity - drag * speed.norm() * speed;
    };
    const Eigen::Vector3d middle = v + 0.5 * kDragStep * acceleration(v);
    p += kDragStep * middle;
    v += kDragStep * acceleration(middle);
  }
  return path;
}

/// Between two samples on the straight line, which leaves 1.2 um.
Eigen::Vector3d position_at(const std::vector<Eigen::Vector3d>& path, double t) {
  const double at = std::min(t / kDragStep, static_cast<double>(path.size() - 1));
  const auto k = std::min(static_cast<size_t>(at), path.size() - 2);
  return path[k] + (at - static_cast<double>(k)) * (path[k + 1] - path[k]);
}

/// By how much, s, a hand that starts at the release would be at a position of the path before the object, where that
/// is most; negative where it is late everywhere. An estimate: only some solutions of inverse kinematics are tried.
double largest_head_start(const Chain& chain, const std::vector<Eigen::Vector3d>& path, const JointVector& start,
                          const CounterRandom& random) {
  const JointVector speed = chain.velocity().cwiseMin(kSpeedWhereUnlimited), acceleration = default_acceleration(speed);
  const controller::MultiStartIk ik(chain);
  uint64_t counter = 0;
  double best = -std::numeric_limits<double>::infinity();
  const auto step = static_cast<size_t>(std::lround(kPathStep / kDragStep));
  for (size_t k = 0; k < path.size(); k += step) {
    if ((path[k] - chain.fixed(0).translation()).norm() > chain.reach()) continue;
    for (int attempt = 0; attempt < kSolutions; ++attempt) {
      const controller::TaskTarget target{.position = path[k]};
      const controller::IkSolution found =
          attempt == 0 ? ik.best(target, start) : ik.first(target, uniform_posture(chain, random, counter));
      if (found.error_m > 1e-5) break;
      const double needed = controller::least_time(found.theta - start, speed, acceleration);
      best = std::max(best, kDragStep * static_cast<double>(k) - needed);
    }
  }
  return best;
}

}  // namespace

Eigen::Vector3d Throw::position(double t) const {
  return release + t * velocity + 0.5 * t * t * kGravity;
}

JointVector waiting_posture(const Chain& chain) {
  JointVector theta(chain.size());
  for (int i = 0; i < chain.size(); ++i) theta[i] = (chain.sample_lower(i) + chain.sample_upper(i)) / 2;
  return theta;
}

Throw sample_throw(const Chain& chain, uint64_t seed, uint64_t index) {
  const CounterRandom random = random_of(seed, index, 0);
  uint64_t counter = 0;
  Throw thrown;
  thrown.flight_s = random.uniform(counter++, 0.5, 0.9);
  const double away = random.uniform(counter++, 1.5, 3), from = random.uniform(counter++, 0, 2 * std::numbers::pi),
               above = random.uniform(counter++, -0.3, 0.3);
  const Eigen::Vector3d aim = chain.position(uniform_posture(chain, random, counter));
  thrown.release = aim + Eigen::Vector3d(away * std::cos(from), away * std::sin(from), above);
  thrown.velocity = (aim - thrown.release - 0.5 * thrown.flight_s * thrown.flight_s * kGravity) / thrown.flight_s;
  return thrown;
}

ThrowResult run_throw(const Chain& chain, const Throw& thrown, const ThrowOptions& options, uint64_t seed,
                      uint64_t index) {
  const double end = thrown.flight_s + kAfter;
  const std::vector<Eigen::Vector3d> path = flight_path(thrown, options.drag, end);
  const JointVector start = waiting_posture(chain);
  controller::ReachOptions reaching;
  controller::GuardedParameters law;
  law.gains = controller::kTrackGains;
  reaching.law = law;
  reaching.prediction_us = controller::kTrackPrediction;
  reaching.intercept.emplace();
  ReachController reach(chain, reaching);
  reach.start(start);
  reach.restart_grid(0);
  const CounterRandom random = random_of(seed, index, 1);
  uint64_t counter = 0;
  std::vector<Knot> knots{{0, start, JointVector::Zero(chain.size())}};
  for (int64_t now = 0; 1e-6 * static_cast<double>(now) < end; now += kImageUs) {
    Eigen::Vector3d seen = position_at(path, 1e-6 * static_cast<double>(now));
    for (double& coordinate : seen) coordinate += options.sigma_m * gaussian(random, counter);
    reach.observe({.utime = now,
                   .seen = true,
                   .position = seen,
                   .covariance = options.sigma_m * options.sigma_m * Eigen::Matrix3d::Identity()});
    while (*reach.next_tick() <= now) {
      const controller::ReachOutput out = reach.tick();
      knots.push_back({1e-6 * static_cast<double>(out.utime + reaching.tick_us) + kLatency, out.theta, out.velocity});
    }
  }
  ThrowResult result{.closest_m = std::numeric_limits<double>::infinity()};
  const JointMotion motion = sampled_motion(knots, end);
  static_assert(kMotionSampling == kDragStep);
  for (size_t k = 0; k < std::min(motion.size(), path.size()); ++k)
    result.closest_m = std::min(result.closest_m, (chain.position(motion[k]) - path[k]).norm());
  const double head_start = largest_head_start(chain, path, start, random_of(seed, index, 2));
  result.in_time = head_start >= 0;
  result.seen_in_time = head_start >= 1e-6 * kFirstKnown * kImageUs + kLatency;
  return result;
}

json run_throws(const Chain& chain, int64_t throws, uint64_t seed, const ThrowOptions& options) {
  int64_t in_time = 0, seen_in_time = 0, met = 0, met_of_seen = 0;
  std::vector<double> closest;
  for (int64_t k = 0; k < throws; ++k) {
    const auto index = static_cast<uint64_t>(k);
    const ThrowResult result = run_throw(chain, sample_throw(chain, seed, index), options, seed, index);
    const bool is_met = result.closest_m <= options.near_m;
    met += is_met;
    in_time += result.in_time;
    seen_in_time += result.seen_in_time;
    met_of_seen += is_met && result.seen_in_time;
    if (result.seen_in_time) closest.push_back(result.closest_m);
  }
  json result{{"throws", throws},
              {"seed", seed},
              {"sigma_m", options.sigma_m},
              {"near_m", options.near_m},
              {"drag", options.drag},
              {"in_time", in_time},
              {"seen_in_time", seen_in_time},
              {"met", met},
              {"met_of_seen_in_time", met_of_seen}};
  if (!closest.empty()) result["closest_m"] = quantiles(closest);
  return result;
}

std::string throws_table(const json& result) {
  const auto count = [&](const char* key) { return result.at(key).get<int64_t>(); };
  std::string row = fmt::format(
      "| throws | met | in time | in time, seen | met of these | closest of these, mm: p50 | p95 |\n"
      "|---|---|---|---|---|---|---|\n| {} | {} | {} | {} | {} |",
      count("throws"), count("met"), count("in_time"), count("seen_in_time"), count("met_of_seen_in_time"));
  for (const char* p : {"p50", "p95"})
    row += result.contains("closest_m") ? fmt::format(" {:.1f} |", 1000 * result["closest_m"][p].get<double>()) : " |";
  return row + "\n";
}

}  // namespace multireach
