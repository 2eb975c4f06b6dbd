#pragma once

#include <span>

#include "vision/matching/target_match.hpp"
#include "vision/tracker_options.hpp"
#include "vision/view.hpp"

namespace multireach::vision {

/// Refuses the chosen candidate for a target that is not tracked, where it is unlikely to be the target: the match gets
/// a status that says why. `chosen`: its number among the candidates. `pairs`: all that were compared. `others`: how
/// many other targets the images show.
void check_first_match(const TrackerOptions& options, size_t chosen, std::span<const ComparedPair> pairs, size_t others,
                       const View& left, const View& right, TargetMatch& found);

}  // namespace multireach::vision
