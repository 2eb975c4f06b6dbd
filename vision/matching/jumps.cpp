#include "vision/matching/jumps.hpp"

#include <algorithm>
#include <array>

#include "numeric/natural_log.hpp"
#include "vision/track/object_prediction.hpp"

namespace multireach::vision {
namespace {

constexpr double kSpeck = 0.25;  // share of the object's radius below which another thing is a speck

/// Whether most of a blob's box is in the box of another target.
bool is_of_others(const Blob& blob, const std::vector<cv::Rect>& others) {
  const auto contains_most = [&](const cv::Rect& other) { return 2 * (other & blob.box).area() > blob.box.area(); };
  return std::ranges::any_of(others, contains_most);
}

/// Whether an image shows nothing but the chosen blob, other targets, specks and, if `background_known`, background.
bool is_alone(const View& view, int chosen, const std::vector<cv::Rect>& others, bool background_known) {
  const auto object = static_cast<size_t>(chosen);
  for (size_t k = 0; k < view.blobs.size(); ++k) {
    if (k == object || is_of_others(view.blobs[k], others)) continue;
    if (background_known && view.appearance[k].is_background()) continue;
    if (view.contours[k].radius_px > kSpeck * view.contours[object].radius_px) return false;
  }
  return true;
}

}  // namespace

bool may_replace(const PairContext& pair, const StereoMatch& other, const StereoMatch& tracked) {
  const View &left = pair.left, &right = pair.right;
  const auto agrees = [&](const View& view, int candidate, int current) {
    const auto c = static_cast<size_t>(candidate);
    return view.is_compact(candidate) &&
           view.contours[c].radius_px > kSpeck * view.contours[static_cast<size_t>(current)].radius_px;
  };
  const auto looks = [&](const StereoMatch& match) {
    const auto l = static_cast<size_t>(match.left), r = static_cast<size_t>(match.right);
    const double radius_px = std::min(left.contours[l].radius_px, right.contours[r].radius_px);
    return evidence_by_looks(match, radius_px, left.appearance[l], right.appearance[r], pair.options.match);
  };
  return agrees(left, other.left, tracked.left) && agrees(right, other.right, tracked.right) &&
         (pair.object.identity.stands_still() || looks(other) > looks(tracked) + kLead);
}

std::optional<StereoMatch::Status> seen_in_one_image(const PairContext& pair, const StereoMatch& match,
                                                     const BoxesOfOthers& others) {
  const TrackerOptions& options = pair.options;
  const TrackedObject& object = pair.object;
  using Status = StereoMatch::Status;
  const bool elsewhere = match.status == Status::kOutsidePredictionGate || match.status == Status::kSeveralElsewhere ||
                         match.status == Status::kUnlikely || match.status == Status::kNoDistance;
  if (match.status != Status::kSeen && !elsewhere) return std::nullopt;
  const auto p_C = predicted_in_cameras(options, object, pair.times);
  if (!p_C || !(object.radius_m > 0)) return std::nullopt;
  struct Expected {
    bool shown = false;  // by a blob
    bool far = false;    // from the match
  };
  const auto expected_in = [&](Side side, const View& view, const CameraModel& camera,
                               const Eigen::Vector2d& matched_px) {
    constexpr double kAbout = 2;  // radii of the target
    const Eigen::Vector3d& expected_C = (*p_C)[index(side)];
    const Eigen::Vector2d centre = camera.project(expected_C);
    const double radius_px = camera.focal_px() * object.radius_m / expected_C.norm(),
                 most = options.match.max_size_ratio;
    Expected expected{.shown = false, .far = (matched_px - centre).norm() > kAbout * radius_px};
    for (size_t k = 0; k < view.blobs.size() && !view.wider(); ++k) {
      if (is_of_others(view.blobs[k], others[index(side)])) continue;
      if (object.identity.known() && view.appearance[k].is_background()) continue;
      const double size = view.contours[k].radius_px / radius_px;
      const bool alike = size * most > 1 && size < most && view.is_compact(static_cast<int>(k));
      if (alike && (view.contours[k].centre_px - centre).norm() < radius_px) expected.shown = true;
    }
    return expected;
  };
  const Expected in_left = expected_in(Side::kLeft, pair.left, options.rig.left, match.left_px);
  const Expected in_right = expected_in(Side::kRight, pair.right, options.rig.right, match.right_px);
  if (in_left.shown == in_right.shown) return std::nullopt;
  if (in_left.shown && in_left.far) return Status::kNotInRight;
  if (in_right.shown && in_right.far) return Status::kNotInLeft;
  return std::nullopt;
}

bool has_bounced(const PairContext& pair, const PositionEstimate& there, const StereoMatch& match,
                 const BoxesOfOthers& others) {
  const TrackerOptions& options = pair.options;
  const TrackedObject& object = pair.object;
  constexpr int kMostConfirmations = 3;  // the default: who asks for more wants certainty
  if (options.track.confirmations > kMostConfirmations) return false;
  if (!object.track.may_bounce_to(pair.times.pair, there) || !(object.radius_m > 0)) return false;
  const Eigen::Vector3d p_L = options.rig.X_WL.inverse() * match.point.p_W;
  const auto looks_like_it = [&](Side side, const View& view, int chosen) {
    if (view.wider() || view.full || !view.whole) return false;
    if (object.identity.known() && view.appearance[static_cast<size_t>(chosen)].is_background()) return false;
    const SphereContour& contour = view.contours[static_cast<size_t>(chosen)];
    const double distance_m = (side == Side::kLeft ? p_L : options.rig.X_RL * p_L).norm();
    const double sigmas =
        natural_log(contour.value.z() * distance_m / object.radius_m) / natural_log(options.match.max_size_ratio);
    const bool round = contour.kind == SphereContour::Kind::kEdges || view.is_compact(chosen);
    return round && !contour.is_cut_off_blob() && -0.5 * sigmas * sigmas > Evidence::kOtherSize &&
           is_alone(view, chosen, others[index(side)], object.identity.known());
  };
  return looks_like_it(Side::kLeft, pair.left, match.left) && looks_like_it(Side::kRight, pair.right, match.right);
}

}  // namespace multireach::vision
