// Where a tracked object is expected, and what of the images is searched for it.
#include <algorithm>

#include "vision/stereo_tracker.hpp"
#include "vision/track/search_window.hpp"

namespace multireach::vision {
namespace {

constexpr double kWindowRadii = 2;   // of the object, around its predicted position, to include some background
constexpr double kWindowMargin = 8;  // pixels

}  // namespace

cv::Rect StereoTracker::window(Side side, int64_t utime) const {
  const cv::Rect whole = search_area(side);
  // Both images of the same pair, for what is compared with everything else.
  const bool look = std::ranges::any_of(cameras_, [](const CameraState& camera) {
    return camera.looks < kFirstLooks || camera.since_look + 1 >= kLookEvery;
  });
  // A target that the last pair did not show may have jumped.
  if (look || track_.status() != TargetTrack::Status::kTracked) return whole;
  const cv::Rect window = predicted_window(side, utime).value_or(whole);
  return window.area() > kWorthwhile * whole.area() ? whole : window;
}

std::optional<cv::Rect> StereoTracker::predicted_window(Side side, int64_t utime) const {
  const auto predicted = track_.predicted(utime);
  if (!predicted || radius_m_ <= 0 || !identity_.confirmed()) return std::nullopt;
  const StereoRig& rig = options_.rig;
  const bool left = side == Side::kLeft;
  const CameraModel& camera = left ? rig.left : rig.right;
  Eigen::Vector3d p = rig.X_WL.inverse() * predicted->position;
  if (!left) p = rig.X_RL * p;
  const auto found = search_window(camera, p, predicted->covariance,
                                   {.nearer_m = radius_m_,
                                    .around_m = kWindowRadii * radius_m_,
                                    .margin_px = kWindowMargin,
                                    .least_z_m = radius_m_});
  if (!found) return std::nullopt;
  const cv::Rect window = *found & search_area(side);
  return window.empty() ? std::nullopt : std::optional(window);
}

/// What is known of the target at the time of the left image, to which rig_at() refers a match. A prediction over a
/// time after which the target counts as lost says nothing.
TargetHistory StereoTracker::history_at(const PairTimes& times) const {
  TargetHistory history;
  const auto seen = track_.last_seen_utime();
  if (track_.status() == TargetTrack::Status::kLost || !seen) return history;
  if (static_cast<double>(times.pair - *seen) > 1e6 * options_.track.coast_s) return history;
  history.steady = track_.predicted_steady(times.pair);
  history.manoeuvring = track_.predicted(times.pair);
  for (auto* predicted : {&history.steady, &history.manoeuvring}) {
    if (*predicted) (*predicted)->position += track_.velocity() * offset_s(times.left, times.pair);
  }
  history.radius_m = radius_m_;
  return history;
}

std::optional<std::array<Eigen::Vector3d, 2>> StereoTracker::expected_in_cameras(const PairTimes& times) const {
  const TargetHistory history = history_at(times);
  if (!history.steady) return std::nullopt;
  const Eigen::Vector3d p_L = options_.rig.X_WL.inverse() * history.steady->position, p_R = rig_at(times).X_RL * p_L;
  return p_L.z() > 0 && p_R.z() > 0 ? std::optional(std::array{p_L, p_R}) : std::nullopt;
}

std::optional<std::array<Eigen::Vector2d, 2>> StereoTracker::expected_px(const PairTimes& times) const {
  const auto p_C = expected_in_cameras(times);
  if (!p_C) return std::nullopt;
  return std::array{options_.rig.left.project((*p_C)[0]), options_.rig.right.project((*p_C)[1])};
}

}  // namespace multireach::vision
