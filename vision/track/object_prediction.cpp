#include "vision/track/object_prediction.hpp"

#include "vision/track/exposure_skew.hpp"
#include "vision/track/search_window.hpp"

namespace multireach::vision {
namespace {

constexpr double kWindowRadii = 2;   // of the object, around its predicted position, to include some background
constexpr double kWindowMargin = 8;  // pixels

}  // namespace

StereoRig motion_compensated_rig(const TrackerOptions& options, const TrackedObject& object, const PairTimes& times) {
  StereoRig rig = options.rig;
  const double later = offset_s(times.right, times.pair) - offset_s(times.left, times.pair);
  rig.X_RL.translation() += rig.X_RL.linear() * (rig.X_WL.linear().transpose() * (object.track.velocity() * later));
  return rig;
}

TargetHistory history_at(const TrackerOptions& options, const TrackedObject& object, const PairTimes& times) {
  const TargetTrack& track = object.track;
  TargetHistory history;
  const auto seen = track.last_seen_utime();
  if (track.status() == TargetTrack::Status::kLost || !seen) return history;
  if (static_cast<double>(times.pair - *seen) > 1e6 * options.track.coast_s) return history;
  history.steady = track.predicted_steady(times.pair);
  history.manoeuvring = track.predicted(times.pair);
  for (auto* predicted : {&history.steady, &history.manoeuvring}) {
    if (*predicted) (*predicted)->position += track.velocity() * offset_s(times.left, times.pair);
  }
  history.radius_m = object.radius_m;
  return history;
}

std::optional<std::array<Eigen::Vector3d, 2>> predicted_in_cameras(const TrackerOptions& options,
                                                                   const TrackedObject& object,
                                                                   const PairTimes& times) {
  const TargetHistory history = history_at(options, object, times);
  if (!history.steady) return std::nullopt;
  const Eigen::Vector3d p_L = options.rig.X_WL.inverse() * history.steady->position;
  const Eigen::Vector3d p_R = motion_compensated_rig(options, object, times).X_RL * p_L;
  return p_L.z() > 0 && p_R.z() > 0 ? std::optional(std::array{p_L, p_R}) : std::nullopt;
}

std::optional<std::array<Eigen::Vector2d, 2>> predicted_px(const TrackerOptions& options, const TrackedObject& object,
                                                           const PairTimes& times) {
  const auto p_C = predicted_in_cameras(options, object, times);
  if (!p_C) return std::nullopt;
  return std::array{options.rig.left.project((*p_C)[0]), options.rig.right.project((*p_C)[1])};
}

std::optional<cv::Rect> predicted_window(const TrackerOptions& options, const TrackedObject& object, Side side,
                                         const cv::Rect& search_area, int64_t utime) {
  const auto predicted = object.track.predicted(utime);
  if (!predicted || object.radius_m <= 0 || !object.identity.confirmed()) return std::nullopt;
  Eigen::Vector3d p = options.rig.X_WL.inverse() * predicted->position;
  if (side == Side::kRight) p = options.rig.X_RL * p;
  const auto found = search_window(options.rig.camera(side), p, predicted->covariance,
                                   {.nearer_m = object.radius_m,
                                    .around_m = kWindowRadii * object.radius_m,
                                    .margin_px = kWindowMargin,
                                    .least_z_m = object.radius_m});
  if (!found) return std::nullopt;
  const cv::Rect window = *found & search_area;
  return window.empty() ? std::nullopt : std::optional(window);
}

PositionEstimate estimate_at_pair(const TrackerOptions& options, const TrackedObject& object, const PairTimes& times,
                                  const StereoMatch& match) {
  const TargetTrack& track = object.track;
  PositionEstimate estimate{match.point.p_W, match.noise_covariance(), match.bias_covariance()};
  const double left = offset_s(times.left, times.pair), later = offset_s(times.right, times.pair) - left;
  if (!match.unknown_motion) estimate.position -= track.velocity() * left;
  const Eigen::Matrix3d speed2 = match.unknown_motion ? unknown_velocity_covariance() : track.velocity_covariance();
  estimate.covariance += speed2 * left * left;
  estimate.covariance += covariance_of_skew(options.rig, match.point.p_W, speed2, later);
  return estimate;
}

}  // namespace multireach::vision
