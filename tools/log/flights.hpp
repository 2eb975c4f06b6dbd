#pragma once

#include <multireach/target_t.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>

#include "controller/ik/multi_start.hpp"
#include "controller/intercept/free_fall_filter.hpp"
#include "tools/log/timed_position.hpp"

namespace multireach {

/// Flights of the thrown target `name`, or of that which was seen first, in the order of time, from its TARGETs and the
/// measured positions of the hand: lists of `begin_s` and `end_s` (when it was known to fall, message time since
/// `origin`), `closest_mm`, the least distance of the hand to the target, and `closest_s`, its time (null without robot
/// states), and `reachable`, whether the target was within the arm's reach at any of these times.
nlohmann::json flights_of(std::span<const target_t> targets, const std::optional<std::string>& name,
                          std::span<const TimedPosition> hand, const controller::FreeFallFilter::Options& fall,
                          const controller::MultiStartIk& search, const JointVector& anywhere, int64_t origin);

}  // namespace multireach
