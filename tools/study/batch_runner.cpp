#include "tools/study/batch_runner.hpp"

#include "controller/batch/guarded_batch.hpp"
#include "controller/batch/paper_batch.hpp"

namespace multireach {

std::unique_ptr<controller::ArmBatch> make_batch(const Chain& chain, const StudyLaw& law, int arms) {
  if (law.guarded) {
    controller::GuardedParameters parameters;
    parameters.gains = law.gains;
    return std::make_unique<controller::GuardedBatch>(chain, parameters, arms);
  }
  return std::make_unique<controller::PaperBatch>(
      chain, controller::PaperParameters{.gains = law.gains, .gamma = 0, .limit_avoidance = true}, law.rechoose_m,
      arms);
}

BatchRunner::BatchRunner(const Chain& chain, const StudyLaw& law, const std::vector<double>& gammas)
    : batch_(make_batch(chain, law, law.guarded ? kGuardedArms : kPaperArms)),
      plan_(chain, {}),
      watches_(static_cast<size_t>(batch_->blocks())),
      running_(static_cast<size_t>(batch_->size())),
      busy_(static_cast<size_t>(batch_->blocks())),
      gammas_(gammas),
      tallies_(gammas.size()) {
  for (size_t k = 0; k < gammas.size(); ++k) tallies_[k].gamma = gammas[k];
}

void BatchRunner::add(int64_t index, const ReachSample& sample) {
  if (next_job_ == jobs_.size()) {
    jobs_.clear();
    next_job_ = 0;
  }
  for (size_t k = 0; k < gammas_.size(); ++k) jobs_.push_back({k, index, sample});
}

bool BatchRunner::begin_next(int arm) {
  if (waiting() == 0) return false;
  const auto block = static_cast<size_t>(arm / kRowLanes);
  const int lane = arm % kRowLanes;
  Job& job = running_[static_cast<size_t>(arm)] = jobs_[next_job_++];
  batch_->start(arm, job.sample.start, job.sample.target, job.sample.target_posture, gammas_[job.gamma]);
  watches_[block].begin(batch_->block(static_cast<int>(block)), lane);
  busy_[block] |= 1U << lane;
  return true;
}

void BatchRunner::harvest(int arm) {
  const auto block = static_cast<size_t>(arm / kRowLanes);
  const Job& job = running_[static_cast<size_t>(arm)];
  const ReachResult result = watches_[block].result(plan_, arm % kRowLanes);
  tallies_[job.gamma].add(job.index, result, plan_.rules);
  if (result.arrived) return;
  const controller::ArmBlock& rows = batch_->block(static_cast<int>(block));
  const int lane = arm % kRowLanes;
  FailedReach failed{job.gamma, job.index, job.sample.start, job.sample.start, job.sample.target, {}, result.error_m};
  for (int i = 0; i < plan_.n; ++i) failed.end[i] = rows.joints[static_cast<size_t>(i)].theta[lane];
  for (int k = 0; k < 3; ++k) failed.hand[k] = rows.x[static_cast<size_t>(k)][lane];
  failed_.push_back(failed);
}

bool BatchRunner::step() {
  bool some = false;
  for (size_t block = 0; block < busy_.size(); ++block) {
    for (int lane = 0; lane < kRowLanes && busy_[block] != 0xff && waiting() > 0; ++lane) {
      if ((busy_[block] >> lane & 1) == 0) begin_next(static_cast<int>(block) * kRowLanes + lane);
    }
    some = some || busy_[block] != 0;
  }
  if (!some) return false;
  batch_->step();
  for (size_t block = 0; block < busy_.size(); ++block) {
    const uint32_t over = watches_[block].take(plan_, batch_->block(static_cast<int>(block))) & busy_[block];
    if (over == 0) continue;
    for (int lane = 0; lane < kRowLanes; ++lane) {
      if (over >> lane & 1) harvest(static_cast<int>(block) * kRowLanes + lane);
    }
    busy_[block] &= ~over;
  }
  return true;
}

}  // namespace multireach
