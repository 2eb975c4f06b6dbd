#pragma once

#include <cstdint>
#include <span>

#include "controller/ik/multi_start.hpp"
#include "kinematics/chain.hpp"
#include "numeric/random.hpp"

namespace multireach {

/// The inputs of one reach.
struct ReachSample {
  JointVector start;
  Eigen::Vector3d target;  // m, in W; reachable
  JointVector target_posture;
};

/// How targets are sampled.
enum class TargetsFrom {
  kSpace,     ///< uniform in the reachable space, as the closed form with its 61 samples finds it; kPostures for an arm
              ///< without closed form, and when none of 10 000 candidates is reachable
  kPostures,  ///< the hand's position at a joint configuration uniform inside the limits
};

/// Samples reaches: a start configuration uniform inside the limits, and a reachable target. The seed and the index of
/// a reach determine it.
class ReachSampler {
 public:
  /// Throws std::invalid_argument when no joint can move: the workspace is empty.
  ReachSampler(const Chain& chain, uint64_t seed, TargetsFrom targets = TargetsFrom::kSpace);
  ReachSample sample(uint64_t index) const;
  /// Whether targets are uniform in space: kSpace, and the arm has a closed form.
  bool from_space() const { return targets_ == TargetsFrom::kSpace && search_.closed_form(); }
  /// Writes the reaches first, first + 1, ... to `samples`; uses SIMD lanes to compute several at once.
  void sample(uint64_t first, std::span<ReachSample> samples) const;

 private:
  ReachSample sample_of_postures(const CounterRandom& random, ReachSample sample) const;

  Chain chain_;
  uint64_t seed_;
  TargetsFrom targets_;
  controller::MultiStartIk search_;
};

}  // namespace multireach
