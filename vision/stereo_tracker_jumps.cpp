// Whether what is seen elsewhere than expected, or by other colours than the learned ones, is the target.
#include <algorithm>
#include <array>
#include <cmath>

#include "numeric/natural_log.hpp"
#include "vision/stereo_tracker.hpp"

namespace multireach::vision {
namespace {

constexpr double kCompact = 0.4;        // see Appearance: an ellipse of 5:2, or a disc with much missing
constexpr double kSpeck = 0.25;         // share of the object's radius below which another thing is a speck
constexpr int64_t kWiderFor = 2000000;  // us since the last match by the learned colours
constexpr double kOtherSize = -2;       // evidence of a size that differs by two standard deviations

bool is_compact(const View& view, int chosen) {
  return view.appearance[static_cast<size_t>(chosen)].compactness > kCompact;
}

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

/// Whether nothing that the learned colours show is the target, or only what is not where it is expected.
bool shows_no_target(StereoMatch::Status status) {
  using Status = StereoMatch::Status;
  static constexpr std::array kNoTarget{Status::kNotInLeft,     Status::kNotInRight,      Status::kInconsistentPair,
                                        Status::kOutsideRegion, Status::kNoDistance,      Status::kOnlyBackground,
                                        Status::kUnlike,        Status::kUnlikely,        Status::kOffColour,
                                        Status::kOtherTarget,   Status::kSeveralElsewhere};
  return std::ranges::find(kNoTarget, status) != kNoTarget.end();
}

}  // namespace

bool StereoTracker::may_look_again(int64_t utime, const StereoMatch& match) const {
  const auto seen = track_.last_seen_utime();
  if (!shows_no_target(match.status) || !seen || utime - identity_.last_utime() > kWiderFor) return false;
  if (static_cast<double>(utime - *seen) > 1e6 * options_.track.coast_s) return false;
  return std::ranges::all_of(std::array{Side::kLeft, Side::kRight}, [&](Side side) {
    const auto window = predicted_window(side, utime);
    return window && window->area() < kWorthwhile * search_area(side).area();
  });
}

bool StereoTracker::is_target_again(const Found& found, const View& left, const View& right) const {
  const StereoMatch& match = found.match;
  if (match.status != StereoMatch::Status::kSeen || found.candidates.empty()) return false;
  return found.candidates.front().evidence.term[Evidence::kSize] > kOtherSize &&
         (match.both_by_contour || (is_compact(left, match.left) && is_compact(right, match.right)));
}

/// Whether `other`, which is not remembered background, is evidence enough against the tracked object, which is: if it
/// is compact and no speck beside that, and that has never moved or looks less like the target by kLead.
bool StereoTracker::may_replace(const StereoMatch& other, const StereoMatch& tracked, const View& left,
                                const View& right) const {
  const auto agrees = [&](const View& view, int candidate, int current) {
    const auto c = static_cast<size_t>(candidate);
    return view.appearance[c].compactness > kCompact &&
           view.contours[c].radius_px > kSpeck * view.contours[static_cast<size_t>(current)].radius_px;
  };
  const auto looks = [&](const StereoMatch& match) {
    const auto l = static_cast<size_t>(match.left), r = static_cast<size_t>(match.right);
    const double radius_px = std::min(left.contours[l].radius_px, right.contours[r].radius_px);
    return evidence_by_looks(match, radius_px, left.appearance[l], right.appearance[r], options_.match);
  };
  return agrees(left, other.left, tracked.left) && agrees(right, other.right, tracked.right) &&
         (identity_.stands_still() || looks(other) > looks(tracked) + kLead);
}

/// Evidence by which another thing must exceed what was found again, in each of the pairs that confirm the jump: as
/// much in their sum as a single choice takes, or two thirds of it where a near jump takes two pairs. More than three
/// successive pairs hardly show more than three.
double StereoTracker::lead_against_found_again() const {
  return kLead / std::clamp(options_.track.confirmations, 1, 3);
}

std::optional<StereoMatch::Status> StereoTracker::seen_in_one_image(
    const PairTimes& times, const StereoMatch& match, const View& left, const View& right,
    const std::array<std::vector<cv::Rect>, 2>& others) const {
  using Status = StereoMatch::Status;
  const bool elsewhere = match.status == Status::kOutsidePredictionGate || match.status == Status::kSeveralElsewhere ||
                         match.status == Status::kUnlikely || match.status == Status::kNoDistance;
  if (match.status != Status::kSeen && !elsewhere) return std::nullopt;
  const auto p_C = expected_in_cameras(times);
  if (!p_C || !(radius_m_ > 0)) return std::nullopt;
  struct Expected {
    bool shown = false;  // by a blob
    bool far = false;    // from the match
  };
  const auto expected_in = [&](Side side, const View& view, const CameraModel& camera,
                               const Eigen::Vector2d& matched_px) {
    constexpr double kAbout = 2;  // radii of the target
    const Eigen::Vector3d& expected_C = (*p_C)[index(side)];
    const Eigen::Vector2d centre = camera.project(expected_C);
    const double radius_px = camera.focal_px() * radius_m_ / expected_C.norm(), most = options_.match.max_size_ratio;
    Expected expected{.shown = false, .far = (matched_px - centre).norm() > kAbout * radius_px};
    for (size_t k = 0; k < view.blobs.size() && !view.wider; ++k) {
      if (is_of_others(view.blobs[k], others[index(side)])) continue;
      if (identity_.known() && view.appearance[k].is_background()) continue;
      const double size = view.contours[k].radius_px / radius_px;
      const bool alike = size * most > 1 && size < most && is_compact(view, static_cast<int>(k));
      if (alike && (view.contours[k].centre_px - centre).norm() < radius_px) expected.shown = true;
    }
    return expected;
  };
  const Expected in_left = expected_in(Side::kLeft, left, options_.rig.left, match.left_px);
  const Expected in_right = expected_in(Side::kRight, right, options_.rig.right, match.right_px);
  if (in_left.shown == in_right.shown) return std::nullopt;
  if (in_left.shown && in_left.far) return Status::kNotInRight;
  if (in_right.shown && in_right.far) return Status::kNotInLeft;
  return std::nullopt;
}

/// Whether a match outside the prediction is the target, which has bounced: it was seen just before, can have got
/// there, has its size, is compact and no background, and nothing else is in view. What is remembered as background may
/// be the target itself until that is known.
bool StereoTracker::has_bounced(int64_t utime, const PositionEstimate& there, const StereoMatch& match,
                                const View& left, const View& right,
                                const std::array<std::vector<cv::Rect>, 2>& others) const {
  constexpr int kMostConfirmations = 3;  // the default: who asks for more wants certainty
  if (options_.track.confirmations > kMostConfirmations) return false;
  if (!track_.may_bounce_to(utime, there) || !(radius_m_ > 0)) return false;
  const Eigen::Vector3d p_L = options_.rig.X_WL.inverse() * match.point.p_W;
  const auto looks_like_it = [&](Side side, const View& view, int chosen) {
    if (view.wider || view.full || view.window != search_area(side)) return false;
    if (identity_.known() && view.appearance[static_cast<size_t>(chosen)].is_background()) return false;
    const SphereContour& contour = view.contours[static_cast<size_t>(chosen)];
    const double distance_m = (side == Side::kLeft ? p_L : options_.rig.X_RL * p_L).norm();
    const double sigmas =
        natural_log(contour.value.z() * distance_m / radius_m_) / natural_log(options_.match.max_size_ratio);
    const bool round = contour.kind == SphereContour::Kind::kEdges || is_compact(view, chosen);
    return round && -0.5 * sigmas * sigmas > kOtherSize &&
           is_alone(view, chosen, others[index(side)], identity_.known());
  };
  return looks_like_it(Side::kLeft, left, match.left) && looks_like_it(Side::kRight, right, match.right);
}

}  // namespace multireach::vision
