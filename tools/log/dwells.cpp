#include "tools/log/dwells.hpp"

#include "tools/log/quantile.hpp"

namespace multireach {
namespace {

using nlohmann::json;

constexpr double kSamePosition = 8e-3;  // m; largest distance from the mean of the first matches during one dwell
constexpr size_t kFirstPositions = 5;
constexpr int64_t kMinDwell = 1000000;  // us; shorter dwells are not reported
constexpr int64_t kFinalPart = 250000;  // us; the error of a reach is the median over this last part of the dwell

json vector(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

}  // namespace

std::vector<Dwell> dwells_of(std::span<const target_t> targets) {
  std::vector<Dwell> dwells;
  Dwell current;
  const auto finish = [&] {
    if (!current.matches.empty() && current.duration() >= kMinDwell) dwells.push_back(current);
    current.matches.clear();
  };
  Eigen::Vector3d anchor = Eigen::Vector3d::Zero();
  for (const target_t& target : targets) {
    if (target.status != target_t::STATUS_TRACKED) continue;
    const TimedPosition seen{target.utime, Eigen::Map<const Eigen::Vector3d>(target.position_m)};
    if (!seen.p_W.allFinite()) continue;
    if (!current.matches.empty() && (seen.p_W - anchor).norm() > kSamePosition) finish();
    current.matches.push_back(seen);
    if (current.matches.size() <= kFirstPositions) anchor = current.mean_position();
  }
  finish();
  return dwells;
}

json reach_of(const Dwell& dwell, std::span<const TimedPosition> hand, int64_t origin) {
  const Eigen::Vector3d target = dwell.mean_position();
  const int64_t begin = dwell.matches.front().utime, end = dwell.matches.back().utime;
  std::vector<double> final_errors;
  int64_t settled = -1;
  for (const TimedPosition& at : hand) {
    if (at.utime < begin || at.utime > end) continue;
    const double error = (at.p_W - target).norm();
    if (error > kReached) {
      settled = -1;
    } else if (settled < 0) {
      settled = at.utime;
    }
    if (at.utime > end - kFinalPart) final_errors.push_back(error);
  }
  json reach{{"target_m", vector(target)},
             {"begin_s", static_cast<double>(begin - origin) * 1e-6},
             {"end_s", static_cast<double>(end - origin) * 1e-6},
             {"hand_error_mm", nullptr},
             {"settle_s", nullptr}};
  if (!final_errors.empty()) reach["hand_error_mm"] = 1e3 * quantile(final_errors, 0.5);
  if (settled >= 0) reach["settle_s"] = static_cast<double>(settled - begin) * 1e-6;
  return reach;
}

}  // namespace multireach
