#pragma once

#include <functional>

#include "studies/study/batch_runner.hpp"

namespace multireach {

struct StudyResult {
  std::vector<Tally> tallies;       ///< one per gamma
  std::vector<FailedReach> failed;  ///< sorted by gamma, then index; only with keep_failed
};

/// Runs the reaches `begin` to `end` - 1 of `sampler` under each gamma, on `threads` threads. `progress`
/// receives the part done, 0 to 1, some hundred times a second. The results, except computing times, do not depend on
/// the number of threads.
StudyResult run_study(const Chain& chain, const ReachSampler& sampler, const StudyLaw& law,
                      const std::vector<double>& gammas, int64_t begin, int64_t end, int threads, bool keep_failed,
                      const std::function<void(double)>& progress = {});

}  // namespace multireach
