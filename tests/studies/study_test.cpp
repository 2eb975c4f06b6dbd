// What the study does side by side against the same one by one.
#include <gtest/gtest.h>

#include "controller/batch/paper_batch.hpp"
#include "studies/study/study.hpp"
#include "tests/test_arms.hpp"

namespace multireach {
namespace {

constexpr uint64_t kSeed = 7;

void expect_same(const ReachResult& a, const ReachResult& b, int64_t reach) {
  EXPECT_EQ(a.arrived, b.arrived) << reach;
  EXPECT_EQ(a.finite, b.finite) << reach;
  EXPECT_EQ(a.error_m, b.error_m) << reach;
  EXPECT_EQ(a.distance_m, b.distance_m) << reach;
  EXPECT_EQ(a.steps, b.steps) << reach;
  if (!a.finite) return;
  EXPECT_EQ(a.limit_excess, b.limit_excess) << reach;
  EXPECT_EQ(a.velocity_excess, b.velocity_excess) << reach;
  EXPECT_EQ(a.path_m, b.path_m) << reach;
  EXPECT_EQ(a.settled_step, b.settled_step) << reach;
}

TEST(Study, SamplesSideBySideAreThoseOneByOne) {
  for (const TargetsFrom targets : {TargetsFrom::kSpace, TargetsFrom::kPostures}) {
    const ReachSampler sampler(testing::hoap2(), kSeed, targets);
    std::vector<ReachSample> samples(61);
    sampler.sample(1000, samples);
    for (size_t k = 0; k < samples.size(); ++k) {
      const ReachSample one = sampler.sample(1000 + k);
      EXPECT_EQ(one.start, samples[k].start);
      EXPECT_EQ(one.target, samples[k].target);
      EXPECT_EQ(one.target_posture, samples[k].target_posture);
    }
  }
}

TEST(Study, CountsWhatEachReachAloneGives) {
  const Chain chain = testing::hoap2();
  const ReachSampler sampler(chain, kSeed);
  const std::vector<double> gammas{0, 350, 10000};
  constexpr int64_t kReaches = 100;
  const JointVector acceleration = JointVector::Constant(4, 20);
  const JointVector weights = Eigen::Vector4d(1, 5, 1, 1);
  const StudyResult study =
      run_study(chain, sampler, {.acceleration = acceleration, .joint_weights = weights}, gammas, 0, kReaches, 3, true);
  for (size_t g = 0; g < gammas.size(); ++g) {
    controller::GuardedParameters parameters;
    parameters.gamma = gammas[g];
    parameters.acceleration = acceleration;
    parameters.joint_weights = weights;
    controller::GuardedLaw law(chain, parameters);
    Tally alone;
    for (int64_t k = 0; k < kReaches; ++k) {
      alone.add(k, run_guarded(law, sampler.sample(static_cast<uint64_t>(k)), {}), {});
    }
    const Tally& side = study.tallies[g];
    EXPECT_EQ(side.samples, kReaches);
    EXPECT_EQ(side.failures, alone.failures);
    EXPECT_EQ(side.steps_total, alone.steps_total);
    EXPECT_EQ(side.max_error_m, alone.max_error_m);
    EXPECT_EQ(side.limit_violations, alone.limit_violations);
    EXPECT_EQ(side.path_ratio.counts(), alone.path_ratio.counts());
    EXPECT_EQ(side.settle_steps.counts(), alone.settle_steps.counts());
  }
}

/// Under the literal law, so that limits are passed and some reaches end as no numbers.
TEST(Study, WatchesABlockAsEachArmAlone) {
  const Chain chain = testing::hoap2();
  const ReachSampler sampler(chain, kSeed);
  const ReachRules rules;
  const MonitorConstants constants(chain, rules);
  int64_t unfinite = 0, beyond = 0;
  for (uint64_t first = 0; first < 10 * kRowLanes; first += kRowLanes) {
    controller::PaperBatch batch(chain, {}, std::numeric_limits<double>::infinity(), kRowLanes);
    MonitorBlock block;
    std::vector<ReachSample> samples;
    std::vector<ReachMonitor> monitors;
    samples.reserve(kRowLanes);
    for (int lane = 0; lane < kRowLanes; ++lane) {
      samples.push_back(sampler.sample(first + static_cast<uint64_t>(lane)));
      ReachSample& sample = samples.back();
      if (lane == 3) sample.target.x() = 1e300;  // the angles overflow
      ASSERT_TRUE(batch.start(lane, sample.start, sample.target, sample.target_posture));
      block.begin(batch.block(0), lane);
      monitors.emplace_back(chain, sample, rules, batch.x(lane));
    }
    uint32_t over = 0;
    while (over != (1U << kRowLanes) - 1) {
      batch.step();
      const uint32_t now = block.update(constants, batch.block(0));
      for (int lane = 0; lane < kRowLanes; ++lane) {
        if (over >> lane & 1) continue;
        JointVector velocity(chain.size());
        for (int i = 0; i < chain.size(); ++i)
          velocity[i] = batch.block(0).joints[static_cast<size_t>(i)].velocity[lane];
        const bool goes_on = monitors[static_cast<size_t>(lane)].update(batch.theta(lane), velocity, batch.x(lane));
        ASSERT_EQ(goes_on, (now >> lane & 1) == 0) << "reach " << first << " + " << lane;
        if (goes_on) continue;
        const ReachResult result = block.result(constants, lane);
        expect_same(monitors[static_cast<size_t>(lane)].result(), result, static_cast<int64_t>(first) + lane);
        unfinite += result.finite ? 0 : 1;
        beyond += result.limit_excess > 0 ? 1 : 0;
        over |= 1U << lane;
      }
    }
  }
  EXPECT_GT(unfinite, 0);
  EXPECT_GT(beyond, 10);
}

}  // namespace
}  // namespace multireach
