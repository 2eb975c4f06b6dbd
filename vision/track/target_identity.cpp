#include "vision/track/target_identity.hpp"

#include <algorithm>
#include <cmath>

namespace multireach::vision {
namespace {

constexpr int kEnough = 3;              // matches of either kind that confirm the target
constexpr double kDiameter = 2;         // radii: an object that moved this far covers none of where it was
constexpr double kStill = 0.25;         // radii: as far as noise moves the middle of an object that stands still
constexpr double kNew = 0.25;           // largest share of background in a blob where the object moved to
constexpr int64_t kForgets = 10000000;  // us without a match, after which any object of the colour is accepted again

}  // namespace

void TargetIdentity::update(int64_t utime, const Observation& observation, bool elsewhere) {
  if (elsewhere) {
    confirmed_ = strayed_ = false;
    contours_ = moved_ = 0;
    first_px_ = observation.px;
  }
  const double away = std::min((observation.px[0] - first_px_[0]).norm(), (observation.px[1] - first_px_[1]).norm());
  const bool apart = away > kDiameter * observation.radius_px;
  strayed_ = strayed_ || away > kStill * observation.radius_px;
  contours_ = std::min(kEnough, contours_ + (observation.by_contour ? 1 : 0));
  moved_ = std::min(kEnough,
                    moved_ + (apart && observation.background[0] < kNew && observation.background[1] < kNew ? 1 : 0));
  confirmed_ = confirmed_ || contours_ >= kEnough || moved_ >= kEnough;
  known_ = known_ || confirmed_;
  lost_since_ = lost_since_ && !confirmed_;
  last_px_ = observation.px;
  last_radius_px_ = observation.radius_px;
  last_utime_ = utime;
}

void TargetIdentity::update_unseen(int64_t utime, bool lost) {
  if (!lost) return;
  confirmed_ = false;
  lost_since_ = known_;
  contours_ = moved_ = 0;
  if (utime - last_utime_ <= kForgets) return;
  known_ = lost_since_ = false;
  last_radius_px_ = 0;
}

void TargetIdentity::restart_motion_evidence() {
  first_px_ = last_px_;
  strayed_ = false;
  moved_ = 0;
}

std::vector<double> TargetIdentity::serialize(int64_t utime) const {
  const int known = !known_ ? 0 : lost_since_ ? 2 : 1;
  std::vector<double> state{confirmed_ ? 1.0 : 0.0, static_cast<double>(known), strayed_ ? 1.0 : 0.0,
                            static_cast<double>(contours_), static_cast<double>(moved_)};
  for (const auto* points : {&first_px_, &last_px_}) {
    for (const Eigen::Vector2d& px : *points) state.insert(state.end(), {px.x(), px.y()});
  }
  state.push_back(last_radius_px_);
  // Beyond the time after which the target is forgotten the age has no effect.
  state.insert(state.begin(), static_cast<double>(std::min(utime - last_utime_, kForgets + 1)));
  return state;
}

bool TargetIdentity::deserialize(int64_t utime, std::span<const double> state) {
  const auto whole = [](double value, double least, double most) {
    return value >= least && value <= most && value == std::floor(value);
  };
  const bool valid = state.size() == kSerializedSize &&
                     std::ranges::all_of(state, [](double v) { return std::isfinite(v); }) &&
                     whole(state[0], -9e15, 9e15) && whole(state[1], 0, 1) && whole(state[2], 0, 2) &&
                     !(state[1] > 0 && state[2] != 1) && whole(state[3], 0, 1) && whole(state[4], 0, kEnough) &&
                     whole(state[5], 0, kEnough) && state.back() >= 0;
  if (!valid) return false;
  last_utime_ = utime - static_cast<int64_t>(state[0]);
  confirmed_ = state[1] > 0;
  known_ = state[2] > 0;
  lost_since_ = state[2] > 1;
  strayed_ = state[3] > 0;
  contours_ = static_cast<int>(state[4]);
  moved_ = static_cast<int>(state[5]);
  size_t k = 6;
  for (auto* points : {&first_px_, &last_px_}) {
    for (Eigen::Vector2d& px : *points) {
      px = {state[k], state[k + 1]};
      k += 2;
    }
  }
  last_radius_px_ = state.back();
  return true;
}

}  // namespace multireach::vision
