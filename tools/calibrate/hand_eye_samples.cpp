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

namespace multireach {
namespace {

/// One standstill of the hand, and the target positions measured meanwhile.
class Standstill {
 public:
  Standstill(const Eigen::Isometry3d& X_WH, int64_t utime) : begin_utime_(utime) { sample_.X_WH = X_WH; }

  /// Upper bound on the displacement of any point of the hand within 10 cm of its origin, m.
  double distance_to(const Eigen::Isometry3d& X_WH) const {
    constexpr double kHandSize = 0.1;
    return (X_WH.translation() - sample_.X_WH.translation()).norm() +
           kHandSize * Eigen::Quaterniond(X_WH.linear()).angularDistance(Eigen::Quaterniond(sample_.X_WH.linear()));
  }
  void add_target(const Eigen::Vector3d& p_LT, const Eigen::Matrix3d& covariance, int64_t utime) {
    constexpr int64_t kSettling = 300000;  // us; until then, images from before the standstill may arrive
    if (utime - begin_utime_ < kSettling) return;
    if (count_ > 0) {
      constexpr double kFar = 0.01, kFarChi2 = 36;  // larger than noise: in metres, and as chi^2
      const Eigen::Vector3d from_mean = p_LT - sample_.p_LT;
      const Eigen::Matrix3d both = covariance + sample_.covariance;
      if (from_mean.norm() > kFar && from_mean.dot(both.inverse() * from_mean) > kFarChi2) target_moved_ = true;
    }
    ++count_;
    sample_.p_LT += (p_LT - sample_.p_LT) / count_;
    sample_.covariance += (covariance - sample_.covariance) / count_;
  }
  bool has_target() const { return count_ > 0; }
  /// Whether the target moved during the standstill.
  bool target_moved() const { return target_moved_; }
  HandEyeSample sample() const {
    HandEyeSample mean = sample_;
    mean.covariance /= count_;
    return mean;
  }

 private:
  HandEyeSample sample_;
  int64_t begin_utime_;
  double count_ = 0;
  bool target_moved_ = false;
};

/// Collects the standstills of a hand that holds the target.
class Standstills {
 public:
  void add(const Standstill& standstill) {
    if (!standstill.has_target()) return;
    if (standstill.target_moved())
      ++target_moved_;
    else
      samples_.push_back(standstill.sample());
  }
  std::vector<HandEyeSample> samples() {
    const size_t standstills = samples_.size() + target_moved_;
    if (target_moved_ > 1 && 4 * target_moved_ > standstills) {
      throw std::runtime_error("the target moves while the hand stands still, at " + std::to_string(target_moved_) +
                               " of " + std::to_string(standstills) + " positions: the hand does not hold it");
    }
    return std::move(samples_);
  }

 private:
  std::vector<HandEyeSample> samples_;
  size_t target_moved_ = 0;
};

}  // namespace

std::vector<HandEyeSample> samples_from_log(const std::string& path, const Chain& chain, const Eigen::Isometry3d& X_WL,
                                            const LogChoice& choice) {
  LogReader log(path);
  Standstills standstills;
  std::optional<Standstill> standstill;
  std::set<std::string> names;
  bool any_state = false, any_seen = false;
  const Eigen::Isometry3d X_LW = X_WL.inverse();
  const auto end_standstill = [&] {
    if (standstill) standstills.add(*standstill);
    standstill.reset();
  };
  Progress progress;
  while (const auto event = log.next()) {
    progress.show(static_cast<double>(log.position()) / static_cast<double>(log.size()));
    if (event->channel == channel::kRobotState) {
      const auto state = decode<robot_state_t>(event->data);
      const auto theta = state ? from_fields(chain, state->joint_name, state->joint_position) : std::nullopt;
      if (!theta || !theta->allFinite()) continue;
      any_state = true;
      const Eigen::Isometry3d X_WH = chain.pose(*theta);
      if (standstill && standstill->distance_to(X_WH) > choice.still_m) end_standstill();
      if (!standstill) standstill.emplace(X_WH, event->utime);
    } else if (event->channel == channel::kTarget) {
      const auto target = decode<target_t>(event->data);
      if (!target || target->status != target_t::STATUS_TRACKED) continue;
      if (!choice.target.empty() && target->name != choice.target) continue;
      names.insert(target->name);
      any_seen = true;
      if (!standstill) continue;
      const Eigen::Matrix3d covariance =
          Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&target->covariance_m2[0][0]);
      const Eigen::Vector3d p_WT = Eigen::Map<const Eigen::Vector3d>(target->position_m);
      if (!p_WT.allFinite() || !covariance.allFinite()) continue;
      standstill->add_target(X_LW * p_WT, X_LW.linear() * covariance * X_LW.linear().transpose(), event->utime);
    }
  }
  progress.end();
  end_standstill();
  if (!any_state)
    throw InputError(path + ": holds no ROBOT_STATE with the joints from " + chain.base() + " to " + chain.tip());
  if (!any_seen) {
    throw InputError(path + ": holds no TARGET " + (choice.target.empty() ? "" : "'" + choice.target + "' ") +
                     "that was seen");
  }
  if (names.size() > 1)
    throw InputError(path + ": has several targets, '" + *names.begin() + "' and others; pick one with --target-name");
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
