#include "studies/straightness/straightness.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <nlohmann/json.hpp>
#include <thread>

#include "controller/law/guarded_law.hpp"
#include "runtime/progress.hpp"
#include "studies/quantiles.hpp"
#include "studies/straightness/shortest_path.hpp"
#include "studies/study/tally.hpp"

namespace multireach {
namespace {

using nlohmann::json;

constexpr uint64_t kRoadmapSeed = 1;
constexpr double kDlsGain = 0.02;     // of the straight motion, per step: beta of the guarded law
constexpr double kDlsDamping = 0.01;  // of the reach
constexpr double kLeastDistance = 0.01;

ReachResult run_law(controller::GuardedLaw& law, const ReachSample& sample) {
  law.start(sample.start);
  law.set_target({.position = sample.target});
  ReachMonitor monitor(law.chain(), sample, {}, law.x());
  do {
    law.step();
  } while (monitor.update(law.theta(), law.velocity(), law.x()));
  return monitor.result();
}

controller::GuardedParameters with_planned_paths() {
  controller::GuardedParameters parameters;
  parameters.path_work = controller::GuardedParameters::kUsualPathWork;
  return parameters;
}

}  // namespace

ReachResult run_dls(const Chain& chain, const ReachSample& sample, const ReachRules& rules) {
  JointVector theta = sample.start;
  ReachMonitor monitor(chain, sample, rules, chain.position(theta));
  const double damping = kDlsDamping * chain.reach();
  Eigen::Vector3d x;
  PositionJacobian J;
  JointVector velocity = JointVector::Zero(chain.size());
  do {
    chain.position_and_jacobian(theta, x, J);
    const Eigen::Matrix3d A = J * J.transpose() + damping * damping * Eigen::Matrix3d::Identity();
    velocity = J.transpose() * A.ldlt().solve(kDlsGain * (sample.target - x));
    double share = 1;  // of the straight motion that every joint can follow
    for (int i = 0; i < chain.size(); ++i) {
      const double most = chain.velocity()[i] / rules.steps_per_second;
      if (std::abs(velocity[i]) > most) share = std::min(share, most / std::abs(velocity[i]));
    }
    const JointVector next = chain.clamped(theta + share * velocity);
    velocity = next - theta;
    theta = next;
  } while (monitor.update(theta, velocity, chain.position(theta)));
  return monitor.result();
}

std::vector<StraightnessOf> run_straightness(const Chain& chain, const ReachSampler& sampler, int64_t samples,
                                             int nodes, int threads) {
  std::vector<StraightnessOf> reaches(static_cast<size_t>(samples));
  std::optional<Roadmap> roadmap;
  if (nodes > 0) roadmap.emplace(chain, nodes, kRoadmapSeed);
  std::atomic<int64_t> next = 0, finished = 0, working = threads;
  std::vector<std::exception_ptr> faults(static_cast<size_t>(threads));
  const auto work = [&] {
    controller::GuardedLaw guarded(chain), planned(chain, with_planned_paths());
    std::optional<ShortestPath> shortest;
    if (roadmap) shortest.emplace(chain, *roadmap);
    for (int64_t k = next++; k < samples; k = next++) {
      const ReachSample sample = sampler.sample(static_cast<uint64_t>(k));
      StraightnessOf& reach = reaches[static_cast<size_t>(k)];
      reach = {run_law(guarded, sample), run_law(planned, sample), run_dls(chain, sample, {}), {}};
      if (shortest) reach.optimum_m = shortest->length_m(sample);
      // The paths of the others exist too. They stay inside the limits, but for the rounding of the last bit.
      for (const ReachResult& other : {reach.guarded, reach.planned, reach.dls}) {
        if (!reach.optimum_m || !other.arrived) continue;
        reach.optimum_m = std::min(*reach.optimum_m, other.path_m + other.error_m);
      }
      ++finished;
    }
  };
  {
    std::vector<std::jthread> pool;
    for (size_t t = 0; t < faults.size(); ++t) {
      pool.emplace_back([&, t] {
        try {
          work();
        } catch (...) {
          faults[t] = std::current_exception();
          next = samples;
        }
        --working;
      });
    }
    Progress progress;
    while (working > 0) {
      progress.show(static_cast<double>(finished) / static_cast<double>(std::max<int64_t>(1, samples)));
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  for (const std::exception_ptr& fault : faults) {
    if (fault) std::rethrow_exception(fault);
  }
  return reaches;
}

json straightness_json(const std::vector<StraightnessOf>& reaches) {
  const auto numbers = [&](bool only_where_dls_arrives) {
    json result = json::object();
    const auto method = [&](const char* name, const ReachResult StraightnessOf::*of) {
      std::vector<double> ratios, settled;
      int64_t arrived = 0, beyond = 0, count = 0;
      for (const StraightnessOf& reach : reaches) {
        const ReachResult& one = reach.*of;
        if (one.distance_m <= kLeastDistance || (only_where_dls_arrives && !reach.dls.arrived)) continue;
        ++count;
        beyond += one.limit_excess > ReachRules{}.excess || one.velocity_excess > ReachRules{}.excess;
        if (!one.arrived) continue;
        ++arrived;
        ratios.push_back(one.path_m / one.distance_m);
        settled.push_back(static_cast<double>(one.settled_step) / ReachRules{}.steps_per_second);
      }
      result[name] = {{"reaches", count},
                      {"arrived", arrived},
                      {"beyond_limits", beyond},
                      {"path_ratio", quantiles(ratios)},
                      {"settle_s", quantiles(settled)}};
    };
    method("guarded", &StraightnessOf::guarded);
    method("planned paths", &StraightnessOf::planned);
    method("damped least squares", &StraightnessOf::dls);
    std::vector<double> optimum;
    for (const StraightnessOf& reach : reaches) {
      if (reach.dls.distance_m <= kLeastDistance || (only_where_dls_arrives && !reach.dls.arrived)) continue;
      if (reach.optimum_m) optimum.push_back(*reach.optimum_m / reach.dls.distance_m);
    }
    if (!optimum.empty()) {
      result["upper bound of the optimum"] = {{"reaches", optimum.size()}, {"path_ratio", quantiles(optimum)}};
    }
    return result;
  };
  return {{"all", numbers(false)}, {"where damped least squares arrives", numbers(true)}};
}

std::string straightness_table(const json& result) {
  std::string table =
      "| reaches | path of the hand | arrived, % | path p50 | p90 | p95 | p99 | settled, s: p50 | p95 |\n"
      "|---|---|---|---|---|---|---|---|---|\n";
  const auto number = [](const json& value, const char* format) {
    char text[40];
    std::snprintf(text, sizeof text, format, value.is_number() ? value.get<double>() : NAN);
    return std::string(value.is_number() ? text : "-") + " | ";
  };
  for (const char* which : {"all", "where damped least squares arrives"}) {
    for (const char* name : {"guarded", "planned paths", "damped least squares", "upper bound of the optimum"}) {
      const json& rows = result.at(which);
      if (!rows.contains(name)) continue;
      const json& row = rows.at(name);
      const auto count = row.at("reaches").get<double>();
      table += "| " + std::string(which) + " | " + name + " | ";
      table += row.contains("arrived") && count > 0 ? number(100 * row.at("arrived").get<double>() / count, "%.2f")
                                                    : std::string("- | ");
      for (const char* p : {"p50", "p90", "p95", "p99"}) table += number(row.at("path_ratio").at(p), "%.3f");
      for (const char* p : {"p50", "p95"}) {
        table += row.contains("settle_s") ? number(row.at("settle_s").at(p), "%.2f") : std::string("- | ");
      }
      table.pop_back();
      table += "\n";
    }
  }
  return table;
}

}  // namespace multireach
