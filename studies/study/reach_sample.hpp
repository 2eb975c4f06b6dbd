#pragma once

#include <cstdint>
#include <span>

#include "controller/ik/posture_search.hpp"
#include "kinematics/chain.hpp"
#include "numeric/random.hpp"

namespace multireach {

/// The inputs of one reach.
struct ReachSample {
  JointVector start;
  Eigen::Vector3d target;  // m, in W; within reach
  JointVector target_posture;
};

/// How targets are drawn.
enum class TargetsFrom {
  kSpace,     ///< uniform in the reachable space, as far as the closed form with its 61 samples knows it; kPostures
              ///< for an arm without one, and where so little is within reach that no point of 10 000 is
  kPostures,  ///< the hand's position at a posture uniform inside the limits
};

/// Reach number `index` of the series `seed`: a start posture uniform inside the limits, and a target within reach.
class ReachSampler {
 public:
  /// Throws std::invalid_argument when no joint can move: the workspace is empty.
  ReachSampler(const Chain& chain, uint64_t seed, TargetsFrom targets = TargetsFrom::kSpace);
  ReachSample sample(uint64_t index) const;
  /// The reaches `first`, first + 1, ... one for each element of `samples`; several are looked for side by side.
  void sample(uint64_t first, std::span<ReachSample> samples) const;

 private:
  bool from_space() const { return targets_ == TargetsFrom::kSpace && search_.closed_form(); }
  ReachSample sample_of_postures(const CounterRandom& random, ReachSample sample) const;

  Chain chain_;
  uint64_t seed_;
  TargetsFrom targets_;
  controller::PostureSearch search_;
};

}  // namespace multireach
