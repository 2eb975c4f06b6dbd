#include "vision/track/target_identity.hpp"

#include <algorithm>
#include <cmath>

#include "vision/colour/colour_background.hpp"

namespace multireach::vision {
namespace {

constexpr int kEnough = 3;                 // matches of either kind that confirm the target
constexpr double kDiameter = 2;            // radii: an object that moved this far covers none of where it was
constexpr double kStill = 0.25;            // radii: as far as noise moves the middle of an object that stands still
constexpr double kNew = 0.25;              // largest share of background in a blob where the object moved to
constexpr double kAppearanceTime_s = 0.5;  // time constant of the target's appearance: a choice

}  // namespace

void TargetIdentity::update(int64_t utime, const Observation& observation, TargetTrack::Start start) {
  using Start = TargetTrack::Start;
  if (start == Start::kJumpAtOnce) {
    first_px_ = observation.px;
    moved_ = 0;
  } else if (start != Start::kNone) {
    if (confirmed()) confirmation_ = Confirmation::kBeforeJump;
    has_moved_ = convincing_ = false;
    contours_ = moved_ = 0;
    first_px_ = observation.px;
    began_utime_ = utime;
    found_again_ = known();
  }
  const double away = std::min((observation.px[0] - first_px_[0]).norm(), (observation.px[1] - first_px_[1]).norm());
  const bool apart = away > kDiameter * observation.radius_px;
  convincing_ = convincing_ || observation.convincing;
  has_moved_ = has_moved_ || away > kStill * observation.radius_px;
  const double background = std::max(observation.background[0], observation.background[1]);
  const bool shape = observation.by_contour && (observation.of_known_size || background < ColourBackground::kExplained);
  contours_ = std::min(kEnough, contours_ + (shape ? 1 : 0));
  moved_ = std::min(kEnough, moved_ + (apart && background < kNew ? 1 : 0));
  if (contours_ >= kEnough || moved_ >= kEnough) confirmation_ = Confirmation::kNow;
  const bool sure = confirmed() && !(found_again_ && doubtful(utime));
  if (sure && observation.appearance.radius_m > 0) {
    const double elapsed_s = 1e-6 * static_cast<double>(utime - appearance_utime_);
    const double weight = appearance_.radius_m > 0 ? std::clamp(elapsed_s / kAppearanceTime_s, 0.0, 1.0) : 1;
    appearance_.radius_m += weight * (observation.appearance.radius_m - appearance_.radius_m);
    appearance_.compactness += weight * (observation.appearance.compactness - appearance_.compactness);
    appearance_utime_ = utime;
  } else if (sure && observation.by_contour && appearance(utime).radius_m > 0) {
    appearance_utime_ = utime;  // a sphere's contour, as of a ball that the border cuts off, shows that it is the same
  }
  last_px_ = observation.px;
  last_radius_px_ = observation.radius_px;
  last_utime_ = utime;
}

void TargetIdentity::update_unseen(int64_t utime, bool lost) {
  if (!lost) return;
  if (known()) confirmation_ = Confirmation::kBeforeLoss;
  contours_ = moved_ = 0;
  if (utime - last_utime_ <= kForgets) return;
  confirmation_ = Confirmation::kNever;
  found_again_ = false;
  last_radius_px_ = 0;
  appearance_ = {};
}

TargetAppearance TargetIdentity::appearance(int64_t utime) const {
  return utime - appearance_utime_ <= kForgets ? appearance_ : TargetAppearance{};
}

void TargetIdentity::restart_motion_evidence() {
  first_px_ = last_px_;
  has_moved_ = false;
  moved_ = 0;
}

std::vector<double> TargetIdentity::serialize(int64_t utime) const {
  const double before = !known() ? 0 : established() ? 1 : 2;
  std::vector<double> state{confirmed() ? 1.0 : 0.0, before, has_moved_ ? 1.0 : 0.0, static_cast<double>(contours_),
                            static_cast<double>(moved_)};
  for (const auto* points : {&first_px_, &last_px_}) {
    for (const Eigen::Vector2d& px : *points) state.insert(state.end(), {px.x(), px.y()});
  }
  const auto age = [&](int64_t since) { return static_cast<double>(utime - since); };
  state.insert(state.end(), {last_radius_px_, (found_again_ ? 1.0 : 0.0) + (convincing_ ? 2.0 : 0.0), age(began_utime_),
                             age(appearance_utime_), appearance_.radius_m, appearance_.compactness});
  state.insert(state.begin(), age(last_utime_));
  return state;
}

bool TargetIdentity::deserialize(int64_t utime, std::span<const double> state) {
  const auto whole = [](double value, double least, double most) {
    return value >= least && value <= most && value == std::floor(value);
  };
  const bool valid =
      state.size() == kSerializedSize && std::ranges::all_of(state, [](double v) { return std::isfinite(v); }) &&
      whole(state[0], -9e15, 9e15) && whole(state[1], 0, 1) && whole(state[2], 0, 2) &&
      !(state[1] > 0 && state[2] != 1) && whole(state[3], 0, 1) && whole(state[4], 0, kEnough) &&
      whole(state[5], 0, kEnough) && state[14] >= 0 && whole(state[15], 0, 3) && whole(state[16], -9e15, 9e15) &&
      whole(state[17], -9e15, 9e15) && state[18] >= 0 && state[19] >= 0 && !(state[18] > 0 && state[2] == 0);
  constexpr double kFarthest = 1e6;  // pixels
  if (!valid || !std::ranges::all_of(state.subspan(6, 9), [](double v) { return std::abs(v) < kFarthest; }))
    return false;
  last_utime_ = utime - static_cast<int64_t>(state[0]);
  confirmation_ = state[1] > 0    ? Confirmation::kNow
                  : state[2] == 0 ? Confirmation::kNever
                  : state[2] == 1 ? Confirmation::kBeforeJump
                                  : Confirmation::kBeforeLoss;
  has_moved_ = state[3] > 0;
  contours_ = static_cast<int>(state[4]);
  moved_ = static_cast<int>(state[5]);
  size_t k = 6;
  for (auto* points : {&first_px_, &last_px_}) {
    for (Eigen::Vector2d& px : *points) {
      px = {state[k], state[k + 1]};
      k += 2;
    }
  }
  last_radius_px_ = state[14];
  const int kind = static_cast<int>(state[15]);
  found_again_ = kind % 2 == 1;
  convincing_ = kind >= 2;
  began_utime_ = utime - static_cast<int64_t>(state[16]);
  appearance_utime_ = utime - static_cast<int64_t>(state[17]);
  appearance_ = {state[18], state[19]};
  return true;
}

}  // namespace multireach::vision
