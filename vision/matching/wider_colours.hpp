#pragma once

#include "vision/matching/pair_context.hpp"
#include "vision/matching/target_match.hpp"

namespace multireach::vision {

// A target that its learned colours do not show is looked for once more with the wider ones.

/// Whether a match by the learned colours missed a target that the wider ones may show: it shows no target, or not
/// where it is expected, and the target was matched by the learned colours less than two seconds before, and seen in
/// the time that it may coast. `utime`: of the pair, us.
[[nodiscard]] bool may_show_more(const TrackerOptions& options, const TrackedObject& object, int64_t utime,
                                 const StereoMatch& match);

/// Whether what was found with the wider colours is the target: of its size, and with a sphere contour in both
/// images, or, where its radius is not known, compact.
[[nodiscard]] bool is_target_again(const TrackerOptions& options, const TargetMatch& found, const View& left,
                                   const View& right);

}  // namespace multireach::vision
