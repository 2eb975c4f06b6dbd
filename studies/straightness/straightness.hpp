#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "studies/study/reach_sample.hpp"
#include "studies/study/run_reach.hpp"

namespace multireach {

/// Length of the hand's path divided by the distance, of one reach. The optimum is nullopt when it was not computed.
struct StraightnessOf {
  ReachResult guarded;              ///< the law `guarded`
  ReachResult planned;              ///< the same with planned paths
  ReachResult dls;                  ///< the damped-least-squares follower
  std::optional<double> optimum_m;  ///< an upper bound of the length of the shortest path inside the limits
};

/// A follower as robots often have it: the hand goes straight to the target; damped least squares convert its velocity
/// into joint velocities, which are scaled so that no joint exceeds its speed limit; every joint stops at its position
/// limits. No acceleration limit.
ReachResult run_dls(const Chain& chain, const ReachSample& sample, const ReachRules& rules);

/// Runs the reaches 0 to `samples` - 1. `nodes`: of the roadmap for the optimum; 0: no optimum. The result does not
/// depend on the number of threads.
std::vector<StraightnessOf> run_straightness(const Chain& chain, const ReachSampler& sampler, int64_t samples,
                                             int nodes, int threads);

/// Numbers of all reaches over 1 cm: for every method the quantiles of path / distance and of the settling time.
nlohmann::json straightness_json(const std::vector<StraightnessOf>& reaches);
/// The same as rows of a Markdown table.
std::string straightness_table(const nlohmann::json& result);

}  // namespace multireach
