#pragma once

#include <memory>
#include <vector>

#include "controller/batch/arm_batch.hpp"
#include "studies/study/tally.hpp"
#include "studies/study/watch_block.hpp"

namespace multireach {

/// A reach that did not arrive.
struct FailedReach {
  size_t gamma = 0;  ///< index of the gamma under which it failed
  int64_t index = 0;
  JointVector start, end;        ///< where it began, and where the arm was at last
  Eigen::Vector3d target, hand;  ///< where the hand should have gone, and where it was at last, m, in W
  double error_m = 0;
};

/// Which law a study is of.
struct StudyLaw {
  bool guarded = true;
  controller::ViteGains gains{0.08, 0.02};
  /// Law paper: theta_T is chosen anew when K(theta_T) is further than this from the target; may be infinite.
  double rechoose_m = 0.01;
};

/// A batch of at least so many arms under `law`.
std::unique_ptr<controller::ArmBatch> make_batch(const Chain& chain, const StudyLaw& law, int arms);

/// Runs reaches, each under every gamma, in a batch of its own: one for each thread. An arm that has finished a reach
/// gets the next one at once.
class BatchRunner {
 public:
  /// `keep_failed`: whether reaches that fail are kept, which takes memory for each.
  BatchRunner(const Chain& chain, const StudyLaw& law, const std::vector<double>& gammas, bool keep_failed);

  /// Takes reach number `index` to be run. Nothing runs until step().
  void add(int64_t index, const ReachSample& sample);
  /// Reaches that wait for an arm.
  size_t waiting() const { return jobs_.size() - next_job_; }
  /// One step of all arms. Returns false when no reach is under way and none waits.
  bool step();

  /// For each gamma what came out so far, and the reaches that failed.
  const std::vector<Tally>& tallies() const { return tallies_; }
  const std::vector<FailedReach>& failed() const { return failed_; }
  /// Reaches run to their end, of all gammas.
  int64_t finished() const { return finished_; }

 private:
  struct Job {
    size_t gamma = 0;
    int64_t index = 0;
    ReachSample sample;
  };
  // Few arms fit the fastest cache. The law `paper` needs so many that those whose theta_T is to be chosen anew in a
  // step fill the lanes of that search.
  static constexpr int kGuardedArms = 4 * kRowLanes, kPaperArms = 64 * kRowLanes;

  void harvest(int arm);
  void begin_next(int arm);

  std::unique_ptr<controller::ArmBatch> batch_;
  WatchPlan plan_;
  std::vector<WatchBlock> watches_;
  std::vector<Job> jobs_;  // those from next_job_ on wait
  size_t next_job_ = 0;
  std::vector<Job> under_way_;  // of each arm that runs
  std::vector<double> gammas_;
  std::vector<Tally> tallies_;
  bool keep_failed_;
  std::vector<FailedReach> failed_;
  int64_t finished_ = 0;
};

}  // namespace multireach
