#include "tools/study/reach_sample.hpp"

#include <stdexcept>

namespace multireach {
namespace {

/// Points tried for a reach, in the ball around the arm's shoulder; most of these are within reach.
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
    : chain_(chain), seed_(seed), targets_(targets), search_(chain) {
  for (int i = 0; i < chain.size(); ++i) {
    if (chain.sample_lower(i) < chain.sample_upper(i)) return;
  }
  throw std::invalid_argument("no joint of the chain from '" + chain.base() + "' to '" + chain.tip() +
                              "' can move: its workspace is empty");
}

ReachSample ReachSampler::sample_of_postures(const CounterRandom& random, ReachSample sample) const {
  const JointVector there = uniform_posture(chain_, random, kMaxJoints);
  sample.target = chain_.position(there);
  const controller::FoundPosture found = search_.best({.position = sample.target}, sample.start);
  sample.target_posture = found.error_m <= search_.options().tolerance_m ? found.theta : there;
  return sample;
}

ReachSample ReachSampler::sample(uint64_t index) const {
  const CounterRandom random(seed_, index);
  ReachSample sample;
  sample.start = uniform_posture(chain_, random, 0);
  if (targets_ == TargetsFrom::kPostures || !search_.closed_form()) return sample_of_postures(random, sample);
  const Eigen::Vector3d shoulder = chain_.fixed(0).translation();
  uint64_t counter = kMaxJoints;
  for (int k = 0; k < kTries; ++k, counter += 3) {
    Eigen::Vector3d p;
    for (uint64_t axis = 0; axis < 3; ++axis) p[axis] = random.uniform(counter + axis, -1, 1);
    if (p.squaredNorm() > 1) continue;
    sample.target = shoulder + chain_.reach() * p;
    const auto posture = search_.closed_form_nearest(sample.target, sample.start);
    if (!posture) continue;
    sample.target_posture = *posture;
    return sample;
  }
  return sample_of_postures(random, sample);
}

}  // namespace multireach
