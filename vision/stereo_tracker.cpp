#include "vision/stereo_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "vision/colour/join_parts.hpp"
#include "vision/exposure_skew.hpp"

namespace multireach::vision {
namespace {

constexpr double kFilled = 0.5;  // mask's share of an image above which the colour model is too wide
constexpr double kMore = 2;      // areas, by which the colours as learned show more of the target: a choice
constexpr double kAlone =
    0.5;  // share of the target's compactness: what has less is seen with something else; a choice
// Of a wider colour model (widened()): at a tolerance of three standard deviations at least 0.45 of the saturation more
// or less, and 24 degrees in the plane of chroma, about as much as limits in HSV often allow.
constexpr double kWider = 0.15;
constexpr int kLeastArea = 16;   // pixels, width and height of a search area
constexpr double kDimmest = 10;  // grey levels: no pixel of a black image is brighter

/// The part of an image that is searched.
cv::Rect area_of(const TrackerOptions& options, Side side) {
  const StereoRig& rig = options.rig;
  const bool left = side == Side::kLeft;
  const CameraModel& camera = left ? rig.left : rig.right;
  if (!options.search_region) return {0, 0, camera.width, camera.height};
  const Eigen::Vector3d radius = Eigen::Vector3d::Constant(options.match.radius_m);
  const SearchRegion whole_ball(options.search_region->min() - radius, options.search_region->max() + radius);
  const Eigen::Isometry3d X_LW = rig.X_WL.inverse();
  return search_area(whole_ball, camera, left ? X_LW : rig.X_RL * X_LW);
}

/// The track takes what the match takes for the target.
TargetTrack::Options track_options(const TrackerOptions& options) {
  TargetTrack::Options track = options.track;
  track.gate = options.match.max_prediction_sigmas;
  return track;
}

const TrackerOptions& checked(const TrackerOptions& options) {
  const auto require = [](bool sensible, const char* sentence) {
    if (!sensible) throw std::invalid_argument(sentence);
  };
  require_usable(options.rig);
  // Position of the right camera in the left camera's frame.
  require(options.rig.X_RL.inverse().translation().x() > 0,
          "the right camera is to the left of the left one: the images are swapped, or the baseline's sign is wrong");
  const MatchOptions& match = options.match;
  require(match.radius_m >= 0 && match.radius_tolerance_m >= 0 && options.sigma_px >= 0 && options.min_area_px > 0 &&
              match.max_epipolar_px > 0 && match.max_size_ratio > 1 && match.max_occlusion > 0 &&
              match.max_prediction_sigmas > 0,
          "the tracker's sizes and thresholds must be positive");
  if (options.search_region) {
    require((options.search_region->sizes().array() > 0).all() && options.search_region->sizes().allFinite(),
            "search_region_m: each number of min must be less than that of max");
    const auto sees = [&](Side side) {
      const cv::Rect area = area_of(options, side);
      return area.width >= kLeastArea && area.height >= kLeastArea;
    };
    require(sees(Side::kLeft), "the left camera does not see search_region_m");
    require(sees(Side::kRight), "the right camera does not see search_region_m");
  }
  return options;
}

/// Whether the image is black, as of a covered or dead camera. Samples every eighth pixel in both directions.
bool is_dark(const cv::Mat& bgr) {
  constexpr int kStep = 8;
  for (int row = kStep / 2; row < bgr.rows; row += kStep) {
    const auto* pixels = bgr.ptr<cv::Vec3b>(row);
    for (int column = kStep / 2; column < bgr.cols; column += kStep) {
      const cv::Vec3b& p = pixels[column];
      if (p[0] > kDimmest || p[1] > kDimmest || p[2] > kDimmest) return false;
    }
  }
  return true;
}

}  // namespace

StereoTracker::StereoTracker(const TrackerOptions& options)
    : options_(checked(options)),
      cameras_{camera_state(options, Side::kLeft), camera_state(options, Side::kRight)},
      track_(track_options(options)) {}

ColourModel StereoTracker::wider_model(const ColourModel& model) {
  return widened(model, kWider);
}

StereoTracker::CameraState StereoTracker::camera_state(const TrackerOptions& options, Side side) {
  const bool left = side == Side::kLeft;
  const bool sphere = options.match.radius_m > 0;
  return {left ? options.rig.left : options.rig.right, options.colour[left ? 0 : 1],
          sphere ? SphereContourFitter::kOfASphere : SphereContourFitter::kOfAnything, area_of(options, side)};
}

void StereoTracker::restart() {
  track_ = TargetTrack(track_options(options_));
  identity_ = {};
  calibration_ = {};
  radius_m_ = 0;
  unoccluded_size_ = {};
  shape_covariance_.setZero();
  for (CameraState& camera_state : cameras_) {
    camera_state.gains = {};
    camera_state.background.forget();
    camera_state.motion.forget();
    camera_state.shift = {};
    camera_state.looks = camera_state.since_look = 0;
  }
}

cv::Rect StereoTracker::whole_image(Side side) const {
  const CameraModel& camera = side == Side::kLeft ? options_.rig.left : options_.rig.right;
  return {0, 0, camera.width, camera.height};
}

View StereoTracker::measure(Side side, const cv::Mat& bgr, const cv::Rect& window, bool chroma_subsampled,
                            Colours colours) {
  CameraState& camera_state = cameras_[index(side)];
  const cv::Rect whole = search_area(side);
  View view;
  view.fits = bgr.type() == CV_8UC3 && bgr.size() == whole_image(side).size();
  if (!view.fits) return view;
  view.window = window;
  view.bgr = bgr;
  view.wider = colours == Colours::kWider;
  AdaptedColourModel& model = view.wider ? camera_state.wider : camera_state.model;
  const FoundBlobs found = camera_state.finder.find(bgr, window, model.members(camera_state.gains),
                                                    {.min_area = options_.min_area_px, .most = kMaxBlobs});
  view.filled = found.too_many_runs || static_cast<double>(found.members) > kFilled * whole.area();
  if (view.filled) return view;
  view.full = found.blobs.size() >= kMaxBlobs;
  view.blobs = join_parts(found.blobs);
  const Eigen::Matrix2d additional =
      ray_covariance(side == Side::kLeft ? options_.rig.left : options_.rig.right, options_.sigma_px);
  for (const Blob& blob : view.blobs) {
    view.contours.push_back(camera_state.fitter.fit(bgr, blob, window, chroma_subsampled));
    SphereContour& contour = view.contours.back();
    contour.covariance.topLeftCorner<2, 2>() += additional;
    if (contour.by_centroid) contour.by_centroid->covariance.topLeftCorner<2, 2>() += additional;
    view.appearance.push_back({.background = camera_state.background.share_of(blob),
                               .compactness = compactness(blob),
                               .colour_share = model.share_well_inside(camera_state.gains, bgr, blob)});
  }
  view.dark = view.blobs.empty() && window == whole && is_dark(bgr(window));
  return view;
}

/// The matched position, moved to the time of the pair; its covariance is that by which the track weighs it, with the
/// unknown motion between exposures.
PositionEstimate StereoTracker::estimate_at_pair(const PairTimes& times, const StereoMatch& match) const {
  PositionEstimate estimate{match.point.p_W, match.noise_covariance(), match.bias_covariance()};
  const double left = offset_s(times.left, times.pair), later = offset_s(times.right, times.pair) - left;
  if (!match.unknown_motion) estimate.position -= track_.velocity() * left;
  const Eigen::Matrix3d speed2 = match.unknown_motion ? unknown_velocity_covariance() : track_.velocity_covariance();
  estimate.covariance += speed2 * left * left;
  estimate.covariance += covariance_of_skew(options_.rig, match.point.p_W, speed2, later);
  return estimate;
}

TargetReport StereoTracker::report(int64_t utime, TargetTrack::Status status, const char* reason) const {
  const bool before = status != TargetTrack::Status::kLost && utime < track_.utime();
  const PositionEstimate estimate = before ? track_.estimate_before(utime) : track_.estimate();
  return {.status = status,
          .estimate = {estimate.position, estimate.covariance + estimate.bias_covariance + shape_covariance_},
          .velocity = track_.velocity(),
          .velocity_covariance = track_.velocity_covariance(),
          .last_seen_utime = track_.last_seen_utime(),
          .reason = reason};
}

void StereoTracker::expire(int64_t utime) {
  track_.expire(utime);
  if (track_.status() == TargetTrack::Status::kLost) identity_.update_unseen(utime, true);
}

TargetReport StereoTracker::update_unseen(int64_t utime, const char* reason) {
  if (track_.begun() && utime <= track_.utime()) return report(utime, track_.unseen_status(utime), reason);
  track_.update(utime, std::nullopt);
  return unseen(utime, reason);
}

/// The identity and the colours do not adapt to a match that the track refused.
TargetReport StereoTracker::unseen(int64_t utime, const char* reason) {
  identity_.update_unseen(utime, track_.status() == TargetTrack::Status::kLost);
  for (CameraState& camera_state : cameras_) camera_state.gains = relaxed(camera_state.gains);
  return report(utime, track_.unseen_status(utime), reason);
}

TargetReport StereoTracker::update(const PairTimes& times, const StereoMatch& match, const View& left,
                                   const View& right, const std::array<std::vector<cv::Rect>, 2>& others) {
  const bool newer = !track_.begun() || times.pair > track_.utime();
  const bool in_doubt = identity_.found_again() && identity_.doubtful(identity_.last_utime());
  TargetReport result = update_track(times, match, left, right, others);
  if (newer) {
    const bool followed = result.status == TargetTrack::Status::kTracked;
    if (followed) calibration_.update(match);
    // Where a known target was found again, it may have been seen, but not located, and so learned as background. Only
    // once this is the target beyond doubt: the background tells it from other things.
    const bool beyond_doubt = followed && in_doubt && !identity_.doubtful(times.pair);
    if (beyond_doubt && identity_.confirmed() && !left.wider && !right.wider) {
      cameras_[index(Side::kLeft)].background.forget(left.blobs[static_cast<size_t>(match.left)]);
      cameras_[index(Side::kRight)].background.forget(right.blobs[static_cast<size_t>(match.right)]);
    }
    notice_motion(Side::kLeft, left, times.pair);
    notice_motion(Side::kRight, right, times.pair);
    // What the track has not accepted may be the target that jumps, until further matches tell; and what it has
    // accepted may be partly occluded. Of several things elsewhere, any may be the target.
    using Status = StereoMatch::Status;
    const bool accepted = match.status == Status::kTogether || track_.last_seen_utime() == times.pair;
    const bool may_be_target =
        match.left >= 0 && match.right >= 0 &&
        (accepted || match.status == Status::kSeen || match.status == Status::kOutsidePredictionGate);
    const bool others_are_background = match.status != Status::kSeveralElsewhere;
    learn_background(Side::kLeft, left, may_be_target ? match.left : -1, others[0], others_are_background);
    learn_background(Side::kRight, right, may_be_target ? match.right : -1, others[1], others_are_background);
  }
  return result;
}

/// Notices when a camera moves. What moved in the image has not moved by itself then, and what was learned of the
/// background is forgotten, unless it is still about there.
void StereoTracker::notice_motion(Side side, const View& view, int64_t utime) {
  CameraState& camera_state = cameras_[index(side)];
  if (!view.fits || view.dark || view.window != search_area(side)) return;
  const CameraMotion::Motion motion = camera_state.motion.look(view.bgr(view.window));
  if (motion == CameraMotion::Motion::kNone) return;
  if (motion == CameraMotion::Motion::kLarge) camera_state.background.forget();
  camera_state.shift.last_utime = utime;
  camera_state.shift.total_px += camera_state.motion.moved_px();
  identity_.restart_motion_evidence();
}

/// Learns where the image shows the target's colour besides the target. A target that is not confirmed may be
/// background itself. Where a known target was seen last, it may still be, occluded or too faint to be matched; and
/// where it may have jumped to, it may be.
void StereoTracker::learn_background(Side side, const View& view, int chosen, std::vector<cv::Rect> objects,
                                     bool others_are_background) {
  CameraState& camera_state = cameras_[index(side)];
  if (!view.fits || view.filled || view.dark || view.wider) return;
  cv::Rect object;
  if (identity_.confirmed() && chosen >= 0) object = view.blobs[static_cast<size_t>(chosen)].box;
  if (identity_.known() && identity_.last_radius_px() > 0) {
    const Eigen::Vector2d centre = identity_.last_px(index(side));
    const double half = kTargetRadii * identity_.last_radius_px();
    object |= cv::Rect(static_cast<int>(centre.x() - half), static_cast<int>(centre.y() - half),
                       static_cast<int>(2 * half) + 1, static_cast<int>(2 * half) + 1);
  }
  objects.push_back(object);
  const bool whole = view.window == search_area(side);
  if (others_are_background)
    camera_state.background.learn(view.window, view.blobs, objects, whole ? camera_state.since_look + 1 : 1);
  camera_state.since_look = whole ? 0 : std::min(kLookEvery, camera_state.since_look + 1);
  if (whole) camera_state.looks = std::min(kFirstLooks, camera_state.looks + 1);
}

TargetReport StereoTracker::update_track(const PairTimes& times, const StereoMatch& match, const View& left,
                                         const View& right, const std::array<std::vector<cv::Rect>, 2>& others) {
  using Status = StereoMatch::Status;
  if (track_.begun() && times.pair <= track_.utime())
    return report(times.pair, track_.unseen_status(times.pair), kNotNewer);
  // A match away from the prediction may be a jump: the track accepts it once further matches confirm it, or at once.
  const bool seen = match.status == Status::kSeen || match.status == Status::kOutsidePredictionGate;
  // A mostly occluded target is measured poorly: good enough to continue a track, not to start one.
  const bool partly = (match.status == Status::kOccludedTooMuch || match.status == Status::kCutOff) &&
                      !match.unknown_motion && match.occlusion < BlobCentre::kNotLocated && match.left >= 0 &&
                      match.right >= 0 && track_.status() != TargetTrack::Status::kLost;
  if (!seen && !partly) {
    TargetReport unseen = update_unseen(times.pair, description(match.status));
    unseen.ambiguous = match.status == Status::kAmbiguous;
    return unseen;
  }
  const PositionEstimate estimate = estimate_at_pair(times, match);
  // How far it moved between the exposures does not tell how far it can have got.
  PositionEstimate there = estimate;
  if (match.unknown_motion) there.covariance = match.noise_covariance();
  using Jump = TargetTrack::Jump;
  const Jump jump = !seen                                                        ? Jump::kNever
                    : has_bounced(times.pair, there, match, left, right, others) ? Jump::kAtOnce
                                                                                 : Jump::kIfConfirmed;
  // An unknown motion between the exposures makes the position so uncertain that it may seem to be the expected one.
  const bool elsewhere =
      match.status == Status::kOutsidePredictionGate && match.unknown_motion && times.left != times.right;
  if (!track_.update(times.pair, estimate, jump, elsewhere))
    return unseen(times.pair, description(Status::kOutsidePredictionGate));
  shape_covariance_ = match.shape_covariance.selfadjointView<Eigen::Lower>();  // exactly symmetric, as is restored
  if (partly) return report(times.pair, TargetTrack::Status::kCoasting, description(match.status));
  TargetReport tracked = report(times.pair, TargetTrack::Status::kTracked, description_of_seen(match, options_.match));
  tracked.estimate = {estimate.position, estimate.covariance + shape_covariance_};
  // What only the wider colours show teaches nothing about the target.
  if (left.wider || right.wider) return tracked;
  const Eigen::Vector3d p_L = options_.rig.X_WL.inverse() * match.point.p_W;
  radius_m_ = options_.match.radius_m > 0 ? options_.match.radius_m
                                          : left.contours[static_cast<size_t>(match.left)].value.z() * p_L.norm();
  const auto l = static_cast<size_t>(match.left), r = static_cast<size_t>(match.right);
  const double compactness = std::min(left.appearance[l].compactness, right.appearance[r].compactness);
  const double radius_px = std::min(left.contours[l].radius_px, right.contours[r].radius_px);
  const TargetAppearance before = identity_.appearance(times.pair);
  const bool ragged = compactness < kAlone * before.compactness;
  // What is seen with something else is larger, too: a flat target that has turned, or is partly covered, is not.
  const bool alone = !ragged || radius_by_area(match, left, right) < before.radius_m;
  const bool shows_size = !ragged && tells_size(match, left, right);
  if (shows_size) unoccluded_size_.update(radius_by_area(match, left, right), times.pair);
  identity_.update(times.pair,
                   {.by_contour = match.both_by_contour,
                    .of_known_size = options_.match.radius_m > 0,
                    .convincing = is_convincing(match, radius_px, left.appearance[l], right.appearance[r]),
                    .px = {match.left_px, match.right_px},
                    .radius_px = radius_px,
                    .appearance = shows_size ? TargetAppearance{radius_m_, compactness} : TargetAppearance{},
                    .background = {left.appearance[l].background, right.appearance[r].background}},
                   track_.start());
  // What is not known to be the target must not change its colour, nor what is seen with it.
  if (options_.adapt_colour && identity_.confirmed() && alone) {
    // Without a sphere contour the blob may include other things: adapt more slowly.
    const double quality = match.both_by_contour ? 1 - match.occlusion : 0.5;
    adapt(Side::kLeft, left, match.left, quality);
    adapt(Side::kRight, right, match.right, quality);
  }
  return tracked;
}

void StereoTracker::adapt(Side side, const View& view, int chosen, double quality) {
  CameraState& camera_state = cameras_[index(side)];
  const Blob& blob = view.blobs[static_cast<size_t>(chosen)];
  if (learned_colours_show_more(side, view, blob)) {
    camera_state.gains = returning(camera_state.gains, quality);
    return;
  }
  const IlluminationSample sample = camera_state.model.sample(camera_state.gains, view.bgr, blob);
  camera_state.gains = adapted(camera_state.gains, sample, quality);
}

/// Whether the colours as learned show more of a compact object than those that were adapted, which show `blob`. Gains
/// that follow a part of an object, as the side in the light, lose the rest of it.
bool StereoTracker::learned_colours_show_more(Side side, const View& view, const Blob& blob) {
  CameraState& camera_state = cameras_[index(side)];
  if (are_as_learned(camera_state.gains)) return false;
  const cv::Size margin = blob.box.size() / 2;
  const cv::Rect around = (blob.box - cv::Point(margin)) + margin + margin;
  const FoundBlobs found = camera_state.finder.find(view.bgr, around & view.window, camera_state.learned,
                                                    {.min_area = options_.min_area_px, .most = kMaxBlobs});
  return std::ranges::any_of(join_parts(found.blobs), [&](const Blob& other) {
    const bool same = 2 * static_cast<double>(common_pixels(other, blob)) > blob.area;
    return same && other.area > kMore * blob.area && compactness(other) > compactness(blob);
  });
}

StereoTracker::Found StereoTracker::find(const cv::Mat& left_bgr, const cv::Mat& right_bgr, bool chroma_subsampled) {
  const View left = measure(Side::kLeft, left_bgr, search_area(Side::kLeft), chroma_subsampled);
  const View right = measure(Side::kRight, right_bgr, search_area(Side::kRight), chroma_subsampled);
  return match({}, left, right);
}

}  // namespace multireach::vision
