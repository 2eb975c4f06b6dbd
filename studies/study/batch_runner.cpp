#include "studies/study/batch_runner.hpp"

#include <stdexcept>
#include <string>

#include "controller/batch/guarded_batch.hpp"
#include "controller/batch/paper_batch.hpp"

namespace multireach {

std::unique_ptr<controller::ArmBatch> make_batch(const Chain& chain, const StudyLaw& law, int arms) {
  if (law.guarded) {
    controller::GuardedParameters parameters;
    parameters.gains = law.gains;
    parameters.attractor = law.attractor;
    parameters.steps_per_second = law.steps_per_second;
    parameters.acceleration = law.acceleration;
    parameters.joint_weights = law.joint_weights;
    return std::make_unique<controller::GuardedBatch>(chain, parameters, arms);
  }
  return std::make_unique<controller::PaperBatch>(
      chain, controller::PaperParameters{.gains = law.gains, .gamma = 0, .limit_avoidance = true}, law.drift_m, arms);
}

BatchRunner::BatchRunner(const Chain& chain, const StudyLaw& law, const std::vector<double>& gammas, bool keep_failed)
    : batch_(make_batch(chain, law, law.guarded ? kGuardedArms : kPaperArms)),
      constants_(chain, ReachRules::at(law.steps_per_second)),
      monitors_(static_cast<size_t>(batch_->blocks())),
      running_jobs_(static_cast<size_t>(batch_->size())),
      gammas_(gammas),
      tallies_(gammas.size()),
      keep_failed_(keep_failed) {
  for (size_t k = 0; k < gammas.size(); ++k) tallies_[k].gamma = gammas[k];
}

void BatchRunner::add(int64_t index, const ReachSample& sample) {
  if (next_job_ == jobs_.size()) {
    jobs_.clear();
    next_job_ = 0;
  }
  for (size_t k = 0; k < gammas_.size(); ++k) jobs_.push_back({k, index, sample});
}

void BatchRunner::begin_next(int arm) {
  const auto block = static_cast<size_t>(arm / kRowLanes);
  const int lane = arm % kRowLanes;
  Job& job = running_jobs_[static_cast<size_t>(arm)] = jobs_[next_job_++];
  if (!batch_->start(arm, job.sample.start, job.sample.target, job.sample.target_posture, gammas_[job.gamma])) {
    throw std::logic_error("reach " + std::to_string(job.index) + " of the study cannot be started");
  }
  monitors_[block].begin(batch_->block(static_cast<int>(block)), lane);
}

void BatchRunner::collect_result(int arm) {
  const auto block = static_cast<size_t>(arm / kRowLanes);
  const Job& job = running_jobs_[static_cast<size_t>(arm)];
  const ReachResult result = monitors_[block].result(constants_, arm % kRowLanes);
  tallies_[job.gamma].add(job.index, result, constants_.rules);
  batch_->stop(arm);
  ++finished_;
  if (result.arrived || !keep_failed_) return;
  failed_.push_back(
      {job.gamma, job.index, job.sample.start, batch_->theta(arm), job.sample.target, batch_->x(arm), result.error_m});
}

bool BatchRunner::step() {
  const std::vector<uint32_t>& running = batch_->running();
  bool some = false;
  for (size_t block = 0; block < running.size(); ++block) {
    for (int lane = 0; lane < kRowLanes && waiting() > 0; ++lane) {
      if ((running[block] >> lane & 1) == 0) begin_next(static_cast<int>(block) * kRowLanes + lane);
    }
    some = some || running[block] != 0;
  }
  if (!some) return false;
  batch_->step();
  for (size_t block = 0; block < running.size(); ++block) {
    const uint32_t over = monitors_[block].update(constants_, batch_->block(static_cast<int>(block))) & running[block];
    for (int lane = 0; over >> lane != 0; ++lane) {
      if (over >> lane & 1) collect_result(static_cast<int>(block) * kRowLanes + lane);
    }
  }
  return true;
}

}  // namespace multireach
