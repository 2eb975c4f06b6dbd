#include "studies/study/study.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <thread>
#include <tuple>

namespace multireach {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// The work of one thread: takes reaches from the shared counter until none is left.
class Worker {
 public:
  Worker(const Chain& chain, const StudyLaw& law, const std::vector<double>& gammas, bool keep_failed)
      : runner_(chain, law, gammas, keep_failed) {}

  void work(const ReachSampler& sampler, std::atomic<int64_t>& next, int64_t end, std::atomic<int64_t>& finished) {
    std::vector<ReachSample> samples;
    while (true) {
      const int64_t from = next.fetch_add(kChunk), count = std::min(kChunk, end - from);
      if (count > 0) {
        samples.resize(static_cast<size_t>(count));
        sampler.sample(static_cast<uint64_t>(from), samples);
        for (int64_t k = 0; k < count; ++k) runner_.add(from + k, samples[static_cast<size_t>(k)]);
      }
      const auto begin = Clock::now();
      // While the counter has more reaches, stop as soon as none waits and take more; at the end, finish all.
      while ((count <= 0 || runner_.waiting() > 0) && runner_.step()) {
      }
      seconds_ += seconds_since(begin);
      finished += runner_.finished() - counted_;
      counted_ = runner_.finished();
      if (count <= 0) return;
    }
  }

  const BatchRunner& runner() const { return runner_; }
  /// Time spent on integration steps.
  double seconds() const { return seconds_; }

 private:
  static constexpr int64_t kChunk = 256;

  BatchRunner runner_;
  double seconds_ = 0;
  int64_t counted_ = 0;
};

}  // namespace

StudyResult run_study(const Chain& chain, const ReachSampler& sampler, const StudyLaw& law,
                      const std::vector<double>& gammas, int64_t begin, int64_t end, int threads, bool keep_failed,
                      const std::function<void(double)>& progress) {
  std::vector<std::unique_ptr<Worker>> workers;
  for (int t = 0; t < threads; ++t) workers.push_back(std::make_unique<Worker>(chain, law, gammas, keep_failed));
  std::atomic<int64_t> next = begin, finished = 0, working = threads;
  std::vector<std::exception_ptr> faults(workers.size());
  {
    std::vector<std::jthread> pool;
    for (size_t w = 0; w < workers.size(); ++w) {
      pool.emplace_back([&, w] {
        try {
          workers[w]->work(sampler, next, end, finished);
        } catch (...) {
          faults[w] = std::current_exception();
          next = end;
        }
        --working;
      });
    }
    const double total = static_cast<double>(std::max<int64_t>(1, end - begin)) * static_cast<double>(gammas.size());
    while (working > 0) {
      if (progress) progress(std::min(1.0, static_cast<double>(finished) / total));
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  for (const std::exception_ptr& fault : faults) {
    if (fault) std::rethrow_exception(fault);
  }
  StudyResult result;
  double seconds = 0;
  int64_t steps = 0;
  for (const auto& worker : workers) {
    seconds += worker->seconds();
    const std::vector<Tally>& tallies = worker->runner().tallies();
    if (result.tallies.empty()) {
      result.tallies = tallies;
    } else {
      for (size_t k = 0; k < tallies.size(); ++k) result.tallies[k].merge(tallies[k]);
    }
    const auto& failed = worker->runner().failed();
    result.failed.insert(result.failed.end(), failed.begin(), failed.end());
  }
  std::ranges::sort(result.failed, {}, [](const FailedReach& reach) { return std::tuple(reach.gamma, reach.index); });
  // Steps of all gammas run interleaved, so the time is divided by their number of steps.
  for (const Tally& tally : result.tallies) steps += tally.steps_total;
  for (Tally& tally : result.tallies) {
    tally.seconds = steps > 0 ? seconds * static_cast<double>(tally.steps_total) / static_cast<double>(steps) : 0;
  }
  return result;
}

}  // namespace multireach
