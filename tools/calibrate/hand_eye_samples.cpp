#include "tools/calibrate/hand_eye_samples.hpp"

#include <algorithm>
#include <multireach/robot_state_t.hpp>
#include <multireach/target_t.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "runtime/channels.hpp"
#include "runtime/joint_fields.hpp"
#include "runtime/log_file.hpp"
#include "runtime/message.hpp"
#include "runtime/program.hpp"
#include "runtime/progress.hpp"
#include "vision/reported_covariance.hpp"

namespace multireach {
namespace {

constexpr int64_t kSettling = 300000;  // us; until then, images from before the standstill may arrive

/// Upper bound on the displacement of any point of the hand within 10 cm of its origin, m.
double displacement(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  constexpr double kHandSize = 0.1;
  return (a.translation() - b.translation()).norm() +
         kHandSize * Eigen::Quaterniond(a.linear()).angularDistance(Eigen::Quaterniond(b.linear()));
}

}  // namespace

void Standstills::hand(const Eigen::Isometry3d& X_WH, int64_t utime) {
  if (current_ && displacement(X_WH, current_->mean.X_WH) > still_m_) end();
  if (!current_) {
    current_.emplace();
    current_->mean.X_WH = X_WH;
    current_->begin_utime = utime;
  }
}

void Standstills::target(const Eigen::Vector3d& p_LT, const Eigen::Matrix3d& covariance, int64_t utime) {
  if (!current_ || !p_LT.allFinite() || !covariance.allFinite() || utime - current_->begin_utime < kSettling) return;
  HandEyeSample& mean = current_->mean;
  if (current_->count > 0) {
    constexpr double kFar = 0.01, kFarChi2 = 36;  // larger than noise: in metres, and as chi^2
    const Eigen::Vector3d from_mean = p_LT - mean.p_LT;
    const Eigen::Matrix3d both = covariance + mean.covariance;
    if (from_mean.norm() > kFar && from_mean.dot(both.inverse() * from_mean) > kFarChi2) current_->target_moved = true;
  }
  ++current_->count;
  mean.p_LT += (p_LT - mean.p_LT) / current_->count;
  mean.covariance += (covariance - mean.covariance) / current_->count;
}

void Standstills::end() {
  if (current_ && current_->count > 0) {
    if (current_->target_moved) {
      ++target_moved_;
    } else {
      samples_.push_back(current_->mean);
      samples_.back().covariance /= current_->count;
    }
  }
  current_.reset();
}

void Standstills::require_held() const {
  const size_t standstills = samples_.size() + target_moved_;
  if (target_moved_ > 1 && 4 * target_moved_ > standstills) {
    throw std::runtime_error("the target moves while the hand stands still, at " + std::to_string(target_moved_) +
                             " of " + std::to_string(standstills) + " positions: the hand does not hold it");
  }
}

std::vector<HandEyeSample> samples_from_log(const std::string& path, const Chain& chain,
                                            const std::optional<Eigen::Isometry3d>& X_WL, const LogChoice& choice) {
  LogReader log(path);
  Standstills standstills(choice.still_m);
  std::set<std::string> names;
  bool any_state = false, any_seen = false;
  Progress progress;
  while (const auto event = log.next()) {
    progress.show(static_cast<double>(log.position()) / static_cast<double>(log.size()));
    if (event->channel == channel::kRobotState) {
      const auto state = decode<robot_state_t>(event->data);
      const auto theta = state ? from_fields(chain, state->joint_name, state->joint_position) : std::nullopt;
      if (!theta || !theta->allFinite()) continue;
      any_state = true;
      standstills.hand(chain.pose(*theta), event->utime);
    } else if (event->channel == channel::kTarget) {
      const auto target = decode<target_t>(event->data);
      if (!target || (!choice.target.empty() && target->name != choice.target)) continue;
      const bool in_W = target->status == target_t::STATUS_TRACKED;
      if (!in_W && target->status != target_t::STATUS_UNCALIBRATED) continue;
      if (in_W && !X_WL) {
        throw InputError(path +
                         ": its targets are in the robot's base frame, but the vision file has no left_to_robot; "
                         "give the vision file that the log was made with");
      }
      names.insert(target->name);
      any_seen = true;
      const Eigen::Isometry3d X_LF = in_W ? X_WL->inverse() : Eigen::Isometry3d::Identity();
      Eigen::Matrix3d covariance =
          Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&target->covariance_m2[0][0]);
      const Eigen::Vector3d p_FT = Eigen::Map<const Eigen::Vector3d>(target->position_m);
      if (choice.rig) {
        StereoRig rig = *choice.rig;
        rig.X_WL = X_LF.inverse();
        covariance = vision::measured_covariance(rig, {p_FT, covariance});
      }
      standstills.target(X_LF * p_FT, X_LF.linear() * covariance * X_LF.linear().transpose(), event->utime);
    }
  }
  progress.end();
  standstills.end();
  if (!any_state)
    throw InputError(path + ": holds no ROBOT_STATE with the joints from " + chain.base() + " to " + chain.tip());
  if (!any_seen) {
    throw InputError(path + ": holds no TARGET " + (choice.target.empty() ? "" : "'" + choice.target + "' ") +
                     "that was seen");
  }
  if (names.size() > 1)
    throw InputError(path + ": has several targets, '" + *names.begin() + "' and others; pick one with --target-name");
  standstills.require_held();
  return standstills.samples();
}

std::vector<HandEyeSample> samples_from_csv(const std::string& path, double sigma_m) {
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
  std::vector<HandEyeSample> samples;
  for (int number = 2; std::getline(text, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) continue;
    const std::string where = path + ":" + std::to_string(number);
    const std::vector<double> values = parse_numbers(where, line);
    if (values.size() != columns.size() || !std::ranges::all_of(values, [](double v) { return std::isfinite(v); }))
      throw InputError(where + ": expected " + std::to_string(columns.size()) + " finite numbers");
    const auto value = [&](const char* name) { return values[static_cast<size_t>(column(name))]; };
    HandEyeSample sample;
    sample.p_LT = {value("seen_x_m"), value("seen_y_m"), value("seen_z_m")};
    sample.X_WH.translation() = Eigen::Vector3d(value("hand_x_m"), value("hand_y_m"), value("hand_z_m"));
    if (turned) {
      const Eigen::Quaterniond q(value("hand_qw"), value("hand_qx"), value("hand_qy"), value("hand_qz"));
      if (std::abs(q.norm() - 1) > 0.01) throw InputError(where + ": the quaternion is not of length 1");
      sample.X_WH.linear() = q.normalized().toRotationMatrix();
    }
    const double sigma = has("sigma_m") ? value("sigma_m") : sigma_m;
    if (!(sigma > 0)) throw InputError(where + ": sigma_m must be above 0");
    sample.covariance = sigma * sigma * Eigen::Matrix3d::Identity();
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace multireach
