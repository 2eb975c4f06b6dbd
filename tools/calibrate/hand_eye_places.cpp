#include "tools/calibrate/hand_eye_places.hpp"

#include <algorithm>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>
#include <optional>
#include <set>
#include <sstream>

#include "runtime/channels.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "runtime/nodes/joint_fields.hpp"
#include "runtime/program.hpp"
#include "runtime/progress.hpp"

namespace multireach {
namespace {

/// The hand standing at one place, and what was seen meanwhile.
class Stand {
 public:
  Stand(const Eigen::Isometry3d& X_WH, int64_t utime) : begin_utime_(utime) { place_.X_WH = X_WH; }

  double distance_to(const Eigen::Isometry3d& X_WH) const {
    return (X_WH.translation() - place_.X_WH.translation()).norm();
  }
  void see(const Eigen::Vector3d& p_LT, const Eigen::Matrix3d& covariance, int64_t utime) {
    constexpr int64_t kSettling = 300000;  // us; images of when the hand still moved arrive until then
    if (utime - begin_utime_ < kSettling) return;
    ++count_;
    place_.p_LT += (p_LT - place_.p_LT) / count_;
    place_.covariance += (covariance - place_.covariance) / count_;
  }
  std::optional<HandEyePlace> place() const {
    if (count_ == 0) return std::nullopt;
    HandEyePlace mean = place_;
    mean.covariance /= count_;
    return mean;
  }

 private:
  HandEyePlace place_;
  int64_t begin_utime_;
  double count_ = 0;
};

}  // namespace

std::vector<HandEyePlace> places_from_log(const std::string& path, const Chain& chain, const Eigen::Isometry3d& X_WL,
                                          const LogChoice& choice) {
  LogReader log(path);
  std::vector<HandEyePlace> places;
  std::optional<Stand> stand;
  std::set<std::string> names;
  bool any_state = false, any_seen = false;
  const Eigen::Isometry3d X_LW = X_WL.inverse();
  const auto leave = [&] {
    if (!stand) return;
    if (const auto place = stand->place()) places.push_back(*place);
    stand.reset();
  };
  Progress progress;
  while (const auto event = log.next()) {
    progress.show(static_cast<double>(log.position()) / static_cast<double>(log.size()));
    if (event->channel == channel::kRobotState) {
      const auto state = decode<robot_state_t>(event->data);
      const auto theta = state ? from_fields(chain, state->joint_name, state->angle_rad) : std::nullopt;
      if (!theta || !theta->allFinite()) continue;
      any_state = true;
      const Eigen::Isometry3d X_WH = chain.pose(*theta);
      if (stand && stand->distance_to(X_WH) > choice.still_m) leave();
      if (!stand) stand.emplace(X_WH, event->utime);
    } else if (event->channel == channel::kTarget) {
      const auto target = decode<target_t>(event->data);
      if (!target || target->status != target_t::STATUS_TRACKED) continue;
      if (!choice.target.empty() && target->name != choice.target) continue;
      names.insert(target->name);
      any_seen = true;
      if (!stand) continue;
      const Eigen::Matrix3d covariance =
          Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&target->covariance_m2[0][0]);
      const Eigen::Vector3d p_WT = Eigen::Map<const Eigen::Vector3d>(target->position_m);
      if (!p_WT.allFinite() || !covariance.allFinite()) continue;
      stand->see(X_LW * p_WT, X_LW.linear() * covariance * X_LW.linear().transpose(), event->utime);
    }
  }
  progress.end();
  leave();
  if (!any_state)
    throw InputError(path + ": holds no ROBOT_STATE with the joints from " + chain.base() + " to " + chain.tip());
  if (!any_seen) {
    throw InputError(path + ": holds no TARGET " + (choice.target.empty() ? "" : "'" + choice.target + "' ") +
                     "that was seen");
  }
  if (names.size() > 1)
    throw InputError(path + ": has several targets, '" + *names.begin() + "' and others; say which with --target");
  return places;
}

std::vector<HandEyePlace> places_from_csv(const std::string& path, double sigma_m) {
  std::istringstream text(read_text_file(path));
  std::string line;
  std::getline(text, line);
  std::vector<std::string> columns;
  std::istringstream header(line);
  for (std::string name; std::getline(header, name, ',');) {
    std::erase_if(name, [](char c) { return c == ' ' || c == '\r' || c == '"'; });
    columns.push_back(name);
  }
  const auto column = [&columns](const char* name) { return std::ranges::find(columns, name) - columns.begin(); };
  const auto has = [&](const char* name) { return std::ranges::find(columns, name) != columns.end(); };
  for (const char* name : {"seen_x_m", "seen_y_m", "seen_z_m", "hand_x_m", "hand_y_m", "hand_z_m"}) {
    if (!has(name)) {
      throw InputError(path + ":1: has no column '" + name +
                       "'; expected seen_x_m,seen_y_m,seen_z_m,hand_x_m,hand_y_m,hand_z_m and, where known, "
                       "hand_qw,hand_qx,hand_qy,hand_qz and sigma_m");
    }
  }
  const bool turned = has("hand_qw") && has("hand_qx") && has("hand_qy") && has("hand_qz");
  std::vector<HandEyePlace> places;
  for (int number = 2; std::getline(text, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) continue;
    const std::string where = path + ":" + std::to_string(number);
    const std::vector<double> values = parse_numbers(where, line);
    if (values.size() != columns.size() || !std::ranges::all_of(values, [](double v) { return std::isfinite(v); }))
      throw InputError(where + ": expected " + std::to_string(columns.size()) + " finite numbers");
    const auto value = [&](const char* name) { return values[static_cast<size_t>(column(name))]; };
    HandEyePlace place;
    place.p_LT = {value("seen_x_m"), value("seen_y_m"), value("seen_z_m")};
    place.X_WH.translation() = Eigen::Vector3d(value("hand_x_m"), value("hand_y_m"), value("hand_z_m"));
    if (turned) {
      const Eigen::Quaterniond q(value("hand_qw"), value("hand_qx"), value("hand_qy"), value("hand_qz"));
      if (std::abs(q.norm() - 1) > 0.01) throw InputError(where + ": the quaternion is not of length 1");
      place.X_WH.linear() = q.normalized().toRotationMatrix();
    }
    const double sigma = has("sigma_m") ? value("sigma_m") : sigma_m;
    if (!(sigma > 0)) throw InputError(where + ": sigma_m must be above 0");
    place.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
    places.push_back(place);
  }
  return places;
}

}  // namespace multireach
