#include "camera/rendering/ball_path.hpp"

#include <algorithm>

#include "runtime/config_keys.hpp"

namespace multireach {

namespace {

constexpr double kGravity = 9.81;  // m/s^2

/// One entry of the list `path`.
struct Entry {
  double previous_s = 0, at_s = 0;
  std::optional<Eigen::Vector3d> position, move_to, throw_to;
  std::optional<Eigen::Quaterniond> orientation;
  double over_s = 0, hidden_for_s = 0;
};

void read_point(const Config& config, const std::string& key, std::optional<Eigen::Vector3d>& point) {
  if (config.has(key)) point = Eigen::Map<const Eigen::Vector3d>(config.numbers(key, 3).data());
}

void read_orientation(const Config& config, Entry& entry) {
  if (!config.has("orientation_wxyz")) return;
  const std::vector<double> q = config.numbers("orientation_wxyz", 4);
  const Eigen::Quaterniond wxyz(q[0], q[1], q[2], q[3]);
  if (!(wxyz.norm() > 1e-6)) config.fail("orientation_wxyz", "a quaternion that is not zero");
  entry.orientation = wxyz.normalized();
}

ConfigKeys<Entry> entry_keys() {
  const auto stays = [](const Entry& e) { return !e.position && !e.move_to && !e.throw_to; };
  return ConfigKeys<Entry>("Scene file, entries of path", "One event on the ball's path.")
      .other("at_s", "number, not less than in the entry before", "s", "required", "When it happens.",
             [](const Config& config, Entry& e) { e.at_s = config.number("at_s", e.previous_s, 1e6); })
      .other("position_m", "list of 3 numbers", "m", "none", "The ball jumps to this position in W.",
             [](const Config& config, Entry& e) { read_point(config, "position_m", e.position); })
      .only("in an entry without position_m", [](const Entry& e) { return !e.position; })
      .other("move_to_m", "list of 3 numbers", "m", "none", "The ball moves to this position, with minimum jerk.",
             [](const Config& config, Entry& e) { read_point(config, "move_to_m", e.move_to); })
      .only("in an entry without position_m and move_to_m", [](const Entry& e) { return !e.position && !e.move_to; })
      .other("throw_to_m", "list of 3 numbers", "m", "none",
             "The ball is thrown and falls freely, with 9.81 m/s² against z, to this position.",
             [](const Config& config, Entry& e) { read_point(config, "throw_to_m", e.throw_to); })
      .only("with move_to_m or throw_to_m", [](const Entry& e) { return e.move_to || e.throw_to; })
      .number(
          "over_s", "s", 0, 1e6, [](auto& e) -> auto& { return e.over_s; }, "Duration of the motion.")
      .required()
      .only("in an entry with a position", [=](const Entry& e) { return !stays(e); })
      .other("orientation_wxyz", "list of 4 numbers", "", "as before; 1, 0, 0, 0 at the start",
             "Rotation from the tag's frame to W there, a quaternion; a ball has none.", read_orientation)
      .only("in an entry without a position", stays)
      .number(
          "hidden_for_s", "s", 0, 1e6, [](auto& e) -> auto& { return e.hidden_for_s; },
          "The ball is invisible for so long.")
      .required();
}

}  // namespace

std::string BallPath::config_reference() {
  return entry_keys().reference();
}

BallPath::BallPath(const Config& scene) {
  double previous = 0;
  for (const Config& section : scene.sections("path")) {
    Entry entry;
    entry.previous_s = previous;
    entry_keys().read(section, entry);
    previous = entry.at_s;
    const Eigen::Quaterniond R_WT =
        entry.orientation.value_or(motions_.empty() ? Eigen::Quaterniond::Identity() : motions_.back().R_WT);
    if (entry.position) {
      if (motions_.empty() && entry.at_s != 0) section.fail("at_s", "0 in the first entry");
      motions_.push_back({entry.at_s, 0, *entry.position, R_WT, false});
    } else if (motions_.empty()) {
      section.fail("position_m", "the ball's position at the start, in the first entry");
    } else if (entry.move_to || entry.throw_to) {
      if (entry.at_s < motions_.back().begin_s + motions_.back().duration_s)
        section.fail("at_s", "a time after the motion above has ended");
      const bool falls = entry.throw_to.has_value();
      motions_.push_back({entry.at_s, entry.over_s, falls ? *entry.throw_to : *entry.move_to, R_WT, falls});
    } else {
      invisible_.push_back({entry.at_s, entry.at_s + entry.hidden_for_s});
    }
  }
  if (motions_.empty()) scene.fail("path", "at least one entry with position_m");
}

double BallPath::progress(const Motion& motion, double time_s) {
  const double s = motion.duration_s > 0 ? std::min((time_s - motion.begin_s) / motion.duration_s, 1.0) : 1.0;
  if (motion.falls) return s;
  return s * s * s * (10 + s * (-15 + 6 * s));
}

Eigen::Vector3d BallPath::position(double time_s) const {
  Eigen::Vector3d at = motions_.front().to;
  for (const Motion& motion : motions_) {
    if (motion.begin_s > time_s) break;
    at += progress(motion, time_s) * (motion.to - at);
    if (!motion.falls) continue;
    const double since = std::min(time_s - motion.begin_s, motion.duration_s);
    at.z() += 0.5 * kGravity * since * (motion.duration_s - since);
  }
  return at;
}

Eigen::Quaterniond BallPath::orientation(double time_s) const {
  Eigen::Vector4d at = motions_.front().R_WT.coeffs();
  for (const Motion& motion : motions_) {
    if (motion.begin_s > time_s) break;
    // Of a quaternion and its negative, which are one rotation, the nearer one; normalised linear interpolation.
    Eigen::Vector4d to = motion.R_WT.coeffs();
    if (to.dot(at) < 0) to = -to;
    at = (at + progress(motion, time_s) * (to - at)).normalized();
  }
  return Eigen::Quaterniond(at);
}

bool BallPath::is_invisible(double time_s) const {
  return std::ranges::any_of(
      invisible_, [=](const Interval& interval) { return time_s >= interval.begin_s && time_s < interval.end_s; });
}

}  // namespace multireach
