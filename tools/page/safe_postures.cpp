#include "tools/page/safe_postures.hpp"

#include <algorithm>
#include <cmath>

#include "controller/node/controller_config.hpp"

namespace multireach {
namespace {

controller::Body body_of(const RobotConfig& robot) {
  const controller::ReachOptions options = reach_options_from(robot);
  const auto* guarded = std::get_if<controller::GuardedParameters>(&options.law);
  return guarded ? guarded->body : controller::Body{};
}

}  // namespace

SafePostures::SafePostures(const RobotConfig& robot, const JointVector& first, uint64_t seed)
    : chain_(robot.chain), proximity_(robot.chain, body_of(robot)), lower_(first), upper_(first), random_(seed) {
  constexpr double kMargin = 0.05;  // of the range, from each limit
  for (int i = 0; i < chain_.size(); ++i) {
    const double low = chain_.lower()[i], high = chain_.upper()[i], range = high - low;
    const bool limited = std::isfinite(range);
    const double width = limited ? std::min(kWidth, kShareOfRange * range) : kWidth;
    lower_[i] = first[i] - width;
    upper_[i] = first[i] + width;
    if (!limited) continue;
    lower_[i] = std::clamp(lower_[i], low + kMargin * range, high - kMargin * range);
    upper_[i] = std::clamp(upper_[i], low + kMargin * range, high - kMargin * range);
  }
}

bool SafePostures::way_is_clear(const JointVector& from, const JointVector& to) {
  if (proximity_.nothing_to_avoid()) return true;
  constexpr int kSteps = 20;
  for (int step = 1; step <= kSteps; ++step) {
    const Eigen::VectorXd theta = from + (to - from) * (static_cast<double>(step) / kSteps);
    if (proximity_.clearance(theta) <= 0) return false;
  }
  return true;
}

std::optional<JointVector> SafePostures::next(const JointVector& from,
                                              const std::function<bool(const Eigen::Isometry3d&)>& wanted) {
  constexpr int kTrials = 2000;
  for (int trial = 0; trial < kTrials; ++trial) {
    JointVector theta(chain_.size());
    for (int i = 0; i < chain_.size(); ++i) theta[i] = random_.uniform(drawn_++, lower_[i], upper_[i]);
    if (wanted(chain_.pose(theta)) && way_is_clear(from, theta)) return theta;
  }
  return std::nullopt;
}

}  // namespace multireach
