#pragma once

#include "vision/matching/pair_context.hpp"
#include "vision/matching/target_match.hpp"

namespace multireach::vision {

/// Chooses which blobs in the two views of a pair are the object, and locates it. `others`: what the pair shows of
/// other targets that look like it.
TargetMatch match_pair(const PairContext& pair, const OtherTargets& others);

}  // namespace multireach::vision
