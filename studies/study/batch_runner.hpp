#pragma once

#include <memory>
#include <vector>

#include "controller/batch/arm_batch.hpp"
#include "studies/study/monitor_block.hpp"
#include "studies/study/tally.hpp"

namespace multireach {

/// A reach that did not arrive.
struct FailedReach {
  size_t gamma = 0;  ///< index of the gamma under which it failed
  int64_t index = 0;
  JointVector start, end;        ///< first and last joint configuration
  Eigen::Vector3d target, hand;  ///< target and last position of the hand, m, in W
  double error_m = 0;
};

/// The law that a study runs.
struct StudyLaw {
  bool guarded = true;
  controller::ViteGains gains{0.08, 0.02};
  std::optional<controller::AttractorMotion> attractor{};  ///< law guarded: instead of gains
  double steps_per_second = controller::kReferenceRate;    ///< law guarded
  /// Law paper: theta_T is searched again when K(theta_T) is further than this from the target, m; may be infinite.
  double drift_m = 0.01;
  JointVector acceleration{};   ///< law guarded: of each joint, rad/s^2 (m/s^2); empty for the defaults of the law
  JointVector joint_weights{};  ///< law guarded: infinite locks the joint; empty for the defaults of the law
};

/// Creates a batch of at least `arms` arms under `law`.
std::unique_ptr<controller::ArmBatch> make_batch(const Chain& chain, const StudyLaw& law, int arms);

/// Runs reaches in its own batch, each reach under every gamma. Use one BatchRunner per thread. An arm that finishes a
/// reach immediately starts the next.
class BatchRunner {
 public:
  /// `keep_failed`: whether to store the reaches that fail.
  BatchRunner(const Chain& chain, const StudyLaw& law, const std::vector<double>& gammas, bool keep_failed);

  /// Queues reach number `index`. Nothing runs until step().
  void add(int64_t index, const ReachSample& sample);
  /// Number of reaches, counted for each gamma, that wait for an arm.
  size_t waiting() const { return jobs_.size() - next_job_; }
  /// One step of all arms. Returns false when no reach runs or waits.
  bool step();

  /// The results so far, one Tally per gamma; and the reaches that failed.
  const std::vector<Tally>& tallies() const { return tallies_; }
  const std::vector<FailedReach>& failed() const { return failed_; }
  /// Number of finished reaches, over all gammas.
  int64_t finished() const { return finished_; }

 private:
  struct Job {
    size_t gamma = 0;
    int64_t index = 0;
    ReachSample sample;
  };
  // Few arms fit into the fastest cache. The law `paper` nevertheless needs many, so that the arms that search theta_T
  // in the same step fill the SIMD lanes of the search.
  static constexpr int kGuardedArms = 4 * kRowLanes, kPaperArms = 64 * kRowLanes;

  void collect_result(int arm);
  void begin_next(int arm);

  std::unique_ptr<controller::ArmBatch> batch_;
  MonitorConstants constants_;
  std::vector<MonitorBlock> monitors_;
  std::vector<Job> jobs_;  // jobs from next_job_ on are waiting
  size_t next_job_ = 0;
  std::vector<Job> running_jobs_;  // the current job of each arm
  std::vector<double> gammas_;
  std::vector<Tally> tallies_;
  bool keep_failed_;
  std::vector<FailedReach> failed_;
  int64_t finished_ = 0;
};

}  // namespace multireach
