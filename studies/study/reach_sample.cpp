#include "studies/study/reach_sample.hpp"

#include <stdexcept>

#include "controller/batch/closed_form_batch.hpp"
#include "controller/task/joint_weights.hpp"

namespace multireach {
namespace {

/// Largest number of target candidates per reach, in the ball around the arm's shoulder. Most candidates are reachable.
constexpr int kTries = 10000;

JointVector uniform_posture(const Chain& chain, const CounterRandom& random, uint64_t counter) {
  JointVector theta(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    theta[i] = random.uniform(counter + static_cast<uint64_t>(i), chain.sample_lower(i), chain.sample_upper(i));
  }
  return theta;
}

}  // namespace

ReachSampler::ReachSampler(const Chain& chain, uint64_t seed, TargetsFrom targets)
    : chain_(chain),
      seed_(seed),
      targets_(targets),
      search_(chain, {.joint_weights = controller::default_joint_weights(chain)}) {
  for (int i = 0; i < chain.size(); ++i) {
    if (chain.sample_lower(i) < chain.sample_upper(i)) return;
  }
  throw std::invalid_argument("no joint of the chain from '" + chain.base() + "' to '" + chain.tip() +
                              "' can move: its workspace is empty");
}

ReachSample ReachSampler::sample_of_postures(const CounterRandom& random, ReachSample sample) const {
  const JointVector there = uniform_posture(chain_, random, kMaxJoints);
  sample.target = chain_.position(there);
  const controller::IkSolution found = search_.best({.position = sample.target}, sample.start);
  sample.target_posture = found.error_m <= search_.options().tolerance_m ? found.theta : there;
  return sample;
}

namespace {

/// The target candidates of one reach, in order: uniform in the ball around the arm's shoulder.
class Candidates {
 public:
  Candidates(const Chain& chain, const CounterRandom& random)
      : random_(random), shoulder_(chain.fixed(0).translation()), reach_(chain.reach()) {}

  /// The next candidate; nullopt after kTries.
  std::optional<Eigen::Vector3d> next() {
    while (tries_++ < kTries) {
      Eigen::Vector3d p;
      for (uint64_t axis = 0; axis < 3; ++axis)
        p[static_cast<Eigen::Index>(axis)] = random_.uniform(counter_ + axis, -1, 1);
      counter_ += 3;
      if (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] <= 1) return shoulder_ + reach_ * p;
    }
    return std::nullopt;
  }

 private:
  CounterRandom random_;
  Eigen::Vector3d shoulder_;
  double reach_;
  uint64_t counter_ = kMaxJoints;
  int tries_ = 0;
};

}  // namespace

ReachSample ReachSampler::sample(uint64_t index) const {
  const CounterRandom random(seed_, index);
  ReachSample sample;
  sample.start = uniform_posture(chain_, random, 0);
  if (from_space()) {
    Candidates candidates(chain_, random);
    while (const auto target = candidates.next()) {
      const auto posture = search_.closed_form_nearest(*target, sample.start);
      if (!posture) continue;
      sample.target = *target;
      sample.target_posture = *posture;
      return sample;
    }
  }
  return sample_of_postures(random, sample);
}

void ReachSampler::sample(uint64_t first, std::span<ReachSample> samples) const {
  if (!from_space()) {
    for (size_t k = 0; k < samples.size(); ++k) samples[k] = sample(first + k);
    return;
  }
  // Each lane queries the IK for one reach that has no target yet; when a reach has its target, the lane takes the
  // next.
  struct Open {
    size_t k;
    Candidates candidates;
  };
  controller::IkQueries queries;
  size_t begun = 0;
  const auto ask = [&](int lane, Open& one) {
    const auto target = one.candidates.next();
    if (!target) return false;
    samples[one.k].target = *target;
    for (size_t axis = 0; axis < 3; ++axis) queries.x_T[axis][lane] = (*target)[static_cast<Eigen::Index>(axis)];
    return true;
  };
  std::array<std::optional<Open>, kRowLanes> asked;
  while (true) {
    bool some = false;
    for (int lane = 0; lane < kRowLanes; ++lane) {
      std::optional<Open>& one = asked[static_cast<size_t>(lane)];
      while (one || begun < samples.size()) {
        if (!one) {
          const CounterRandom random(seed_, first + begun);
          samples[begun].start = uniform_posture(chain_, random, 0);
          for (size_t i = 0; i < 4; ++i) queries.theta[i][lane] = samples[begun].start[static_cast<Eigen::Index>(i)];
          one.emplace(Open{begun++, Candidates(chain_, random)});
        }
        if (ask(lane, *one)) break;
        // No candidate was reachable.
        samples[one->k] = sample_of_postures(CounterRandom(seed_, first + one->k), samples[one->k]);
        one.reset();
      }
      some = some || one;
    }
    if (!some) return;
    const uint32_t found = controller::closed_form_batch(search_.closed_form_ik(), queries);
    for (int lane = 0; lane < kRowLanes; ++lane) {
      std::optional<Open>& one = asked[static_cast<size_t>(lane)];
      if (!one || (found >> lane & 1) == 0) continue;
      JointVector posture(4);
      for (size_t i = 0; i < 4; ++i) posture[static_cast<Eigen::Index>(i)] = queries.posture[i][lane];
      samples[one->k].target_posture = posture;
      one.reset();
    }
  }
}

}  // namespace multireach
