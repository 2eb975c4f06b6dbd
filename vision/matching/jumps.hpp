#pragma once

#include <optional>

#include "vision/matching/pair_context.hpp"
#include "vision/matching/target_match.hpp"

namespace multireach::vision {

// Whether what is seen elsewhere than expected is the target.

/// Whether a match outside the prediction is the target, which has bounced: it was seen just before, can have got
/// `there`, has its size, is compact and no background, and nothing else is in view. What is remembered as background
/// may be the target itself until that is known.
[[nodiscard]] bool has_bounced(const PairContext& pair, const PositionEstimate& there, const StereoMatch& match,
                               const BoxesOfOthers& others);

/// Whether `other`, which is not remembered background, is evidence enough against the tracked object, which is: if it
/// is compact and no speck beside that, and that has never moved or looks less like the target by kLead.
[[nodiscard]] bool may_replace(const PairContext& pair, const StereoMatch& other, const StereoMatch& tracked);

/// Where a match is not about where the target is expected, but exactly one image shows a blob there that is like it:
/// the target is where it was expected, and the match is another thing. (Where both images show one, the pair was
/// compared as well, and the choice among candidates stands.) The status names the image in which the target is
/// missing.
std::optional<StereoMatch::Status> seen_in_one_image(const PairContext& pair, const StereoMatch& match,
                                                     const BoxesOfOthers& others);

}  // namespace multireach::vision
