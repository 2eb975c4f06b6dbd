#include "camera/rendering/ball_path.hpp"

#include <algorithm>

namespace multireach {

BallPath::BallPath(const Config& scene) {
  double previous = 0;
  for (const Config& entry : scene.sections("path")) {
    const double at = entry.number("at_s", previous, 1e6);
    previous = at;
    const auto point = [&entry](const std::string& key) -> Eigen::Vector3d {
      return Eigen::Map<const Eigen::Vector3d>(entry.numbers(key, 3).data());
    };
    if (entry.has("position_m")) {
      if (motions_.empty() && at != 0) entry.fail("at_s", "0 in the first entry");
      motions_.push_back({at, 0, point("position_m")});
    } else if (motions_.empty()) {
      entry.fail("position_m", "the ball's place at the start, in the first entry");
    } else if (entry.has("move_to_m")) {
      if (at < motions_.back().begin_s + motions_.back().duration_s)
        entry.fail("at_s", "a time after the motion above has ended");
      motions_.push_back({at, entry.number("over_s", 0, 1e6), point("move_to_m")});
    } else {
      hidden_.push_back({at, at + entry.number("hidden_for_s", 0, 1e6)});
    }
    entry.finish();
  }
  if (motions_.empty()) scene.fail("path", "at least one entry with position_m");
}

Eigen::Vector3d BallPath::position(double time_s) const {
  Eigen::Vector3d at = motions_.front().to;
  for (const Motion& motion : motions_) {
    if (motion.begin_s > time_s) break;
    const double s = motion.duration_s > 0 ? std::min((time_s - motion.begin_s) / motion.duration_s, 1.0) : 1.0;
    at += s * s * s * (10 + s * (-15 + 6 * s)) * (motion.to - at);
  }
  return at;
}

bool BallPath::hidden(double time_s) const {
  return std::ranges::any_of(
      hidden_, [=](const Interval& interval) { return time_s >= interval.begin_s && time_s < interval.end_s; });
}

}  // namespace multireach
