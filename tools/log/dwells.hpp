#pragma once

#include <multireach/target_t.hpp>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "tools/log/timed_position.hpp"

namespace multireach {

inline constexpr double kReached = 5e-3;  ///< m; largest position error that counts as reached

/// A time during which the target stayed at one position.
struct Dwell {
  std::vector<TimedPosition> matches;  ///< images in which it was tracked; not empty
  Eigen::Vector3d mean_position() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const TimedPosition& seen : matches) sum += seen.p_W;
    return sum / static_cast<double>(matches.size());
  }
  int64_t duration() const { return matches.back().utime - matches.front().utime; }
};

/// The dwells of at least a second.
std::vector<Dwell> dwells_of(std::span<const target_t> targets);
/// Reports one dwell of the target, and how the end effector, at the measured positions `hand`, reached it: `target_m`,
/// `begin_s` and `end_s` (message time since `origin`), `hand_error_mm`, `settle_s`.
nlohmann::json reach_of(const Dwell& dwell, std::span<const TimedPosition> hand, int64_t origin);

}  // namespace multireach
