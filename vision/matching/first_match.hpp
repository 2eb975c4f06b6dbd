#pragma once

#include <span>

#include "vision/matching/pair_context.hpp"
#include "vision/matching/target_match.hpp"

namespace multireach::vision {

/// Refuses the chosen candidate of a target that is not tracked, where it is unlikely to be the target: the match gets
/// a status that says why. `chosen`: its number among the candidates. `compared`: all pairs of contours.
/// `others_in_left`: how many other targets the left image shows.
void refuse_unlikely_first_match(const PairContext& pair, size_t chosen, std::span<const ComparedPair> compared,
                                 size_t others_in_left, TargetMatch& found);

}  // namespace multireach::vision
