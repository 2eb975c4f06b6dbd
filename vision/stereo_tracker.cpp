#include "vision/stereo_tracker.hpp"

#include <algorithm>

#include "vision/matching/jumps.hpp"
#include "vision/matching/match_pair.hpp"
#include "vision/matching/matched_size.hpp"
#include "vision/matching/wider_colours.hpp"
#include "vision/track/object_prediction.hpp"

namespace multireach::vision {
namespace {

// Share of the remembered compactness: a match with less does not show the object's shape. More than the share by which
// candidates are refused as ragged (0.4): to learn from, a match must be better than to be followed. A choice.
constexpr double kSameShape = 0.5;
constexpr double kWorthwhile = 0.5;  // above this share of the search area, all of it is searched instead
constexpr double kTargetRadii = 2;   // around where the target was seen last: no background is learned

const TrackerOptions& valid(const TrackerOptions& options) {
  require_valid(options);
  return options;
}

/// The track takes what the match takes for the target.
TargetTrack::Options track_options(const TrackerOptions& options) {
  TargetTrack::Options track = options.track;
  track.gate = options.match.max_prediction_sigmas;
  return track;
}

}  // namespace

StereoTracker::StereoTracker(const TrackerOptions& options)
    : options_(valid(options)),
      detectors_{ObjectDetector(options, Side::kLeft), ObjectDetector(options, Side::kRight)},
      object_{TargetTrack(track_options(options))} {}

void StereoTracker::restart() {
  object_ = {TargetTrack(track_options(options_))};
  calibration_ = {};
  for (ObjectDetector& detector : detectors_) detector.restart();
}

void StereoTracker::expire(int64_t utime) {
  object_.track.expire(utime);
  if (object_.track.status() == TargetTrack::Status::kLost) object_.identity.update_unseen(utime, true);
}

cv::Rect StereoTracker::window(Side side, int64_t utime) const {
  const cv::Rect whole = search_area(side);
  // Both images of the same pair, for what is compared with everything else. A target that the last pair did not show
  // may have jumped.
  if (std::ranges::any_of(detectors_, &ObjectDetector::should_search_all) ||
      object_.track.status() != TargetTrack::Status::kTracked)
    return whole;
  const cv::Rect window = predicted_window(side, utime).value_or(whole);
  return window.area() > kWorthwhile * whole.area() ? whole : window;
}

std::optional<cv::Rect> StereoTracker::predicted_window(Side side, int64_t utime) const {
  return vision::predicted_window(options_, object_, side, search_area(side), utime);
}

View StereoTracker::measure(Side side, int64_t utime, const cv::Mat& bgr, const cv::Rect& window,
                            bool chroma_subsampled, Colours colours) {
  // A ball of known radius is measured by a part of its contour; its parts and what is beside them need no growing.
  const bool known_size = options_.match.radius_m > 0;
  const bool grows = colours == Colours::kLearned && object_.identity.confirmed() && !known_size;
  const cv::Rect expected = grows ? predicted_window(side, utime).value_or(cv::Rect()) : cv::Rect();
  return detectors_[index(side)].measure(bgr, window, chroma_subsampled, colours, expected);
}

TargetMatch StereoTracker::match(const PairTimes& times, const View& left, const View& right,
                                 const OtherTargets& others) const {
  return match_pair({options_, object_, times, left, right}, others);
}

TargetMatch StereoTracker::find(const cv::Mat& left_bgr, const cv::Mat& right_bgr, bool chroma_subsampled) {
  const View left = measure(Side::kLeft, 0, left_bgr, search_area(Side::kLeft), chroma_subsampled);
  const View right = measure(Side::kRight, 0, right_bgr, search_area(Side::kRight), chroma_subsampled);
  return match({}, left, right);
}

bool StereoTracker::is_inside_windows(const PairTimes& times, const StereoMatch& match, const View& left,
                                      const View& right) const {
  if (match.status != StereoMatch::Status::kSeen ||
      !object_.track.expects(times.pair, estimate_at_pair(options_, object_, times, match)))
    return false;
  constexpr int kRead = 10;  // pixels around the blob that the edge measurement reads
  const auto whole = [](const cv::Rect& box, const cv::Rect& window, const cv::Rect& area) {
    return (box.x - kRead >= window.x || window.x == area.x) && (box.y - kRead >= window.y || window.y == area.y) &&
           (box.br().x + kRead <= window.br().x || window.br().x == area.br().x) &&
           (box.br().y + kRead <= window.br().y || window.br().y == area.br().y);
  };
  return !left.growth_cut_off && !right.growth_cut_off &&
         whole(left.blobs[static_cast<size_t>(match.left)].box, left.window, search_area(Side::kLeft)) &&
         whole(right.blobs[static_cast<size_t>(match.right)].box, right.window, search_area(Side::kRight));
}

bool StereoTracker::may_look_again(int64_t utime, const StereoMatch& match) const {
  if (!may_show_more(options_, object_, utime, match)) return false;
  return std::ranges::all_of(std::array{Side::kLeft, Side::kRight}, [&](Side side) {
    const auto window = predicted_window(side, utime);
    return window && window->area() < kWorthwhile * search_area(side).area();
  });
}

TargetReport StereoTracker::report(int64_t utime, TargetTrack::Status status, const char* reason) const {
  const TargetTrack& track = object_.track;
  const bool before = status != TargetTrack::Status::kLost && utime < track.utime();
  const PositionEstimate estimate = before ? track.estimate_before(utime) : track.estimate();
  return {.status = status,
          .estimate = {estimate.position, estimate.covariance + estimate.bias_covariance + object_.shape_covariance},
          .velocity = track.velocity(),
          .velocity_covariance = track.velocity_covariance(),
          .last_seen_utime = track.last_seen_utime(),
          .reason = reason};
}

TargetReport StereoTracker::update_unseen(int64_t utime, const char* reason) {
  TargetTrack& track = object_.track;
  if (track.begun() && utime <= track.utime()) return report(utime, track.unseen_status(utime), reason);
  track.update(utime, std::nullopt);
  return unseen(utime, reason);
}

/// The identity and the colours do not adapt to a match that the track refused.
TargetReport StereoTracker::unseen(int64_t utime, const char* reason) {
  object_.identity.update_unseen(utime, object_.track.status() == TargetTrack::Status::kLost);
  for (ObjectDetector& detector : detectors_) detector.relax();
  return report(utime, object_.track.unseen_status(utime), reason);
}

TargetReport StereoTracker::update(const PairTimes& times, const StereoMatch& match, const View& left,
                                   const View& right, const BoxesOfOthers& others) {
  const TargetTrack& track = object_.track;
  TargetIdentity& identity = object_.identity;
  const bool newer = !track.begun() || times.pair > track.utime();
  const bool in_doubt = identity.found_again() && identity.doubtful(identity.last_utime());
  TargetReport result = update_track(times, match, left, right, others);
  if (!newer) return result;
  auto& [left_detector, right_detector] = detectors_;
  const bool followed = result.status == TargetTrack::Status::kTracked;
  if (followed) calibration_.update(match);
  // Where a known target was found again, it may have been seen, but not located, and so learned as background. Only
  // once this is the target beyond doubt: the background tells it from other things.
  const bool beyond_doubt = followed && in_doubt && !identity.doubtful(times.pair);
  if (beyond_doubt && identity.confirmed() && !left.wider() && !right.wider()) {
    left_detector.forget_background(left.blobs[static_cast<size_t>(match.left)]);
    right_detector.forget_background(right.blobs[static_cast<size_t>(match.right)]);
  }
  // What moved in the image has not moved by itself where the camera moved.
  const bool left_moved = left_detector.notice_motion(left, times.pair);
  if (right_detector.notice_motion(right, times.pair) || left_moved) identity.restart_motion_evidence();
  // What the track has not accepted may be the target that jumps, until further matches tell; and what it has
  // accepted may be partly occluded. Of several things elsewhere, any may be the target.
  using Status = StereoMatch::Status;
  const bool accepted = match.status == Status::kTogether || track.last_seen_utime() == times.pair;
  const bool may_be_target =
      match.left >= 0 && match.right >= 0 &&
      (accepted || match.status == Status::kSeen || match.status == Status::kOutsidePredictionGate);
  const bool others_are_background = match.status != Status::kSeveralElsewhere;
  learn_background(Side::kLeft, left, may_be_target ? match.left : -1, others[0], others_are_background);
  learn_background(Side::kRight, right, may_be_target ? match.right : -1, others[1], others_are_background);
  return result;
}

/// Learns where the image shows the target's colour besides the target. A target that is not confirmed may be
/// background itself. Where a known target was seen last, it may still be, occluded or too faint to be matched; and
/// where it may have jumped to, it may be.
void StereoTracker::learn_background(Side side, const View& view, int chosen, std::vector<cv::Rect> objects,
                                     bool others_are_background) {
  const TargetIdentity& identity = object_.identity;
  cv::Rect object;
  if (identity.confirmed() && chosen >= 0) object = view.blobs[static_cast<size_t>(chosen)].box;
  if (identity.known() && identity.last_radius_px() > 0) {
    const Eigen::Vector2d centre = identity.last_px(index(side));
    const double half = kTargetRadii * identity.last_radius_px();
    object |= cv::Rect(static_cast<int>(centre.x() - half), static_cast<int>(centre.y() - half),
                       static_cast<int>(2 * half) + 1, static_cast<int>(2 * half) + 1);
  }
  objects.push_back(object);
  detectors_[index(side)].learn_background(view, objects, others_are_background);
}

TargetReport StereoTracker::update_track(const PairTimes& times, const StereoMatch& match, const View& left,
                                         const View& right, const BoxesOfOthers& others) {
  using Status = StereoMatch::Status;
  TargetTrack& track = object_.track;
  if (track.begun() && times.pair <= track.utime())
    return report(times.pair, track.unseen_status(times.pair), kNotNewer);
  // A match away from the prediction may be a jump: the track accepts it once further matches confirm it, or at once.
  const bool seen = match.status == Status::kSeen || match.status == Status::kOutsidePredictionGate;
  // A mostly occluded target is measured poorly: good enough to continue a track, not to start one.
  const bool partly = (match.status == Status::kOccludedTooMuch || match.status == Status::kCutOff) &&
                      !match.unknown_motion && match.occlusion < BlobCentre::kNotLocated && match.left >= 0 &&
                      match.right >= 0 && track.status() != TargetTrack::Status::kLost;
  if (!seen && !partly) {
    TargetReport unseen = update_unseen(times.pair, description(match.status));
    unseen.ambiguous = match.status == Status::kAmbiguous;
    return unseen;
  }
  const PositionEstimate estimate = estimate_at_pair(options_, object_, times, match);
  // How far it moved between the exposures does not tell how far it can have got.
  PositionEstimate there = estimate;
  if (match.unknown_motion) there.covariance = match.noise_covariance();
  using Jump = TargetTrack::Jump;
  const Jump jump = !seen                                                                        ? Jump::kNever
                    : has_bounced({options_, object_, times, left, right}, there, match, others) ? Jump::kAtOnce
                                                                                                 : Jump::kIfConfirmed;
  // An unknown motion between the exposures makes the position so uncertain that it may seem to be the expected one.
  const bool elsewhere =
      match.status == Status::kOutsidePredictionGate && match.unknown_motion && times.left != times.right;
  if (!track.update(times.pair, estimate, jump, elsewhere))
    return unseen(times.pair, description(Status::kOutsidePredictionGate));
  object_.shape_covariance =
      match.shape_covariance.selfadjointView<Eigen::Lower>();  // exactly symmetric, as is restored
  if (partly) return report(times.pair, TargetTrack::Status::kCoasting, description(match.status));
  TargetReport tracked = report(times.pair, TargetTrack::Status::kTracked, description_of_seen(match, options_.match));
  tracked.estimate = {estimate.position, estimate.covariance + object_.shape_covariance};
  // What only the wider colours show teaches nothing about the target.
  if (!left.wider() && !right.wider()) learn_from(times, match, left, right);
  return tracked;
}

/// Learns from an accepted match what the target is like: its size, its look, whether it is the target, and its colours
/// in this light.
void StereoTracker::learn_from(const PairTimes& times, const StereoMatch& match, const View& left, const View& right) {
  TargetIdentity& identity = object_.identity;
  const Eigen::Vector3d p_L = options_.rig.X_WL.inverse() * match.point.p_W;
  object_.radius_m = options_.match.radius_m > 0
                         ? options_.match.radius_m
                         : left.contours[static_cast<size_t>(match.left)].value.z() * p_L.norm();
  const auto l = static_cast<size_t>(match.left), r = static_cast<size_t>(match.right);
  const double compactness = std::min(left.appearance[l].compactness, right.appearance[r].compactness);
  const double radius_px = std::min(left.contours[l].radius_px, right.contours[r].radius_px);
  const TargetAppearance before = identity.appearance(times.pair);
  const PairContext pair{options_, object_, times, left, right};
  const double by_area_m = radius_by_area(pair, match);
  const bool same_shape = compactness >= kSameShape * before.compactness;
  // What is seen with something else is larger, too: a flat target that has turned, or is partly occluded, is not.
  const bool alone = same_shape || by_area_m < before.radius_m;
  const bool cut_off = left.contours[l].is_cut_off_blob() || right.contours[r].is_cut_off_blob();
  // What only the wider colours show may be larger than the target.
  const bool shows_size = same_shape && tells_size(pair, match) && !shows_more_than_learned(pair, match);
  if (shows_size) object_.unoccluded_size.update(by_area_m, times.pair);
  identity.update(times.pair,
                  {.by_contour = match.both_by_contour,
                   .of_known_size = options_.match.radius_m > 0,
                   .convincing = !cut_off && is_convincing(match, radius_px, left.appearance[l], right.appearance[r]),
                   .px = {match.left_px, match.right_px},
                   .radius_px = radius_px,
                   .appearance = shows_size ? TargetAppearance{object_.radius_m, compactness} : TargetAppearance{},
                   .background = {left.appearance[l].background, right.appearance[r].background}},
                  object_.track.start());
  // What is not known to be the target must not change its colour, nor what is seen with it.
  if (options_.adapt_colour && identity.confirmed() && alone) {
    // Without a sphere contour the blob may include other things: adapt more slowly.
    const double quality = match.both_by_contour ? 1 - match.occlusion : 0.5;
    detectors_[0].adapt(left, match.left, quality);
    detectors_[1].adapt(right, match.right, quality);
  }
}

}  // namespace multireach::vision
