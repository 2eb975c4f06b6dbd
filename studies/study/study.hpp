#pragma once

#include "studies/study/batch_runner.hpp"

namespace multireach {

struct StudyResult {
  std::vector<Tally> tallies;       ///< of each gamma
  std::vector<FailedReach> failed;  ///< by gamma, then index; when asked for
};

/// Runs the reaches `begin` to `end` - 1 of `sampler` under each gamma, on so many threads, with progress on a
/// terminal. All but the times is the same for any number of threads.
StudyResult run_study(const Chain& chain, const ReachSampler& sampler, const StudyLaw& law,
                      const std::vector<double>& gammas, int64_t begin, int64_t end, int threads, bool keep_failed);

}  // namespace multireach
