#pragma once

#include <optional>

#include "vision/matching/target_match.hpp"
#include "vision/pair_times.hpp"
#include "vision/tracked_object.hpp"
#include "vision/tracker_options.hpp"
#include "vision/view.hpp"

namespace multireach::vision {

// Whether what is seen elsewhere than expected, or by other colours than the learned ones, is the target.

/// Whether a match outside the prediction is the target, which has bounced: it was seen just before, can have got
/// `there`, has its size, is compact and no background, and nothing else is in view. What is remembered as background
/// may be the target itself until that is known. `utime`: of the pair, us.
[[nodiscard]] bool has_bounced(const TrackerOptions& options, const TrackedObject& object, int64_t utime,
                               const PositionEstimate& there, const StereoMatch& match, const View& left,
                               const View& right, const BoxesOfOthers& others);

/// Whether `other`, which is not remembered background, is evidence enough against the tracked object, which is: if it
/// is compact and no speck beside that, and that has never moved or looks less like the target by kLead.
[[nodiscard]] bool may_replace(const TrackerOptions& options, const TargetIdentity& identity, const StereoMatch& other,
                               const StereoMatch& tracked, const View& left, const View& right);

/// Where a match is not about where the target is expected, but exactly one image shows a blob there that is like it:
/// the target is where it was expected, and the match is another thing. (Where both images show one, the pair was
/// compared as well, and the choice among candidates stands.) The status names the image in which the target is
/// missing.
std::optional<StereoMatch::Status> seen_in_one_image(const TrackerOptions& options, const TrackedObject& object,
                                                     const PairTimes& times, const StereoMatch& match, const View& left,
                                                     const View& right, const BoxesOfOthers& others);

/// Whether a match by the learned colours shows no target, or not where it is expected, so that looking for it with the
/// wider colours may help.
[[nodiscard]] bool shows_no_target(StereoMatch::Status status);

/// Whether what was found with the wider colours is the target: of its size, and round.
[[nodiscard]] bool is_target_again(const TargetMatch& found, const View& left, const View& right);

}  // namespace multireach::vision
