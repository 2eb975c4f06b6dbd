#include "vision/stereo_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "vision/colour/join_parts.hpp"

namespace multireach::vision {
namespace {

constexpr double kFilled = 0.5;        // mask's share of an image above which the colour model is too wide
constexpr double kUnknownSpeed = 0.5;  // m/s, standard deviation of the speed of a target that was not tracked
constexpr double kAround = 2;          // radii around where the target is or is expected: no background there
// Of a wider colour model (widened()): at a tolerance of three standard deviations at least 0.45 of the saturation more
// or less, and 24 degrees in the plane of chroma, about as much as limits in HSV often allow.
constexpr double kWider = 0.15;
constexpr int kLeastArea = 16;   // pixels, width and height of a search area
constexpr double kDimmest = 10;  // grey levels: no pixel of a black image is brighter

/// Whether a pair may combine two things that touch, as balls do: in both images the contour is a part of a larger
/// blob, of about the same size, but at different places of it.
bool are_different_parts(const ComparedPair& pair, const View& left, const View& right) {
  constexpr double kLargerBlob = 1.3;  // least area of such a blob, in areas of the contour
  constexpr double kBlobRatio = 1.3;   // largest ratio of the areas of images of the same blob
  constexpr double kOffset = 0.5;      // largest difference of the contour's offset from the blob's centroid, radii
  if (!pair.match.both_by_contour) return false;
  struct Part {
    double area_ratio;
    Eigen::Vector2d offset;
  };
  const auto part_of = [](const View& view, int at) {
    const SphereContour& contour = view.contours[static_cast<size_t>(at)];
    const Blob& blob = view.blobs[static_cast<size_t>(at)];
    const double radius = contour.radius_px;
    return Part{blob.area / (std::numbers::pi * radius * radius), (contour.centre_px - blob.centroid) / radius};
  };
  const Part a = part_of(left, pair.match.left), b = part_of(right, pair.match.right);
  return std::min(a.area_ratio, b.area_ratio) > kLargerBlob &&
         std::max(a.area_ratio, b.area_ratio) < kBlobRatio * std::min(a.area_ratio, b.area_ratio) &&
         (a.offset - b.offset).norm() > kOffset;
}

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

/// Whether a match has a position that can be compared with the search region.
bool is_located(StereoMatch::Status status) {
  using Status = StereoMatch::Status;
  return status == Status::kSeen || status == Status::kOccludedTooMuch || status == Status::kCutOff ||
         status == Status::kWrongRadius || status == Status::kOutsidePredictionGate;
}

bool is_background(const StereoMatch& match, const View& left, const View& right) {
  return match.left >= 0 && match.right >= 0 &&
         left.appearance[static_cast<size_t>(match.left)].background > StereoTracker::kBackgroundShare &&
         right.appearance[static_cast<size_t>(match.right)].background > StereoTracker::kBackgroundShare;
}

}  // namespace

StereoTracker::StereoTracker(const TrackerOptions& options)
    : options_(checked(options)),
      cameras_{camera_state(options, Side::kLeft), camera_state(options, Side::kRight)},
      track_(options.track) {}

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
  track_ = TargetTrack(options_.track);
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

/// Compensates the target's motion between the two exposures: shifts the right camera by the opposite motion, so that
/// both images show the target at the time of the left one.
StereoRig StereoTracker::rig_at(const PairTimes& times) const {
  StereoRig rig = options_.rig;
  if (track_.status() == TargetTrack::Status::kLost) return rig;
  const double later = offset_s(times.right, times.pair) - offset_s(times.left, times.pair);
  rig.X_RL.translation() += rig.X_RL.linear() * (rig.X_WL.linear().transpose() * (track_.velocity() * later));
  return rig;
}

StereoTracker::Found StereoTracker::match(const PairTimes& times, const View& left, const View& right,
                                          const OtherTargets& others) const {
  using Status = StereoMatch::Status;
  const auto failed = [](Status status) {
    Found found;
    found.match.status = status;
    return found;
  };
  if (!left.fits || !right.fits) return failed(Status::kWrongImageSize);
  if (left.filled || right.filled) return failed(Status::kColourEverywhere);
  if (left.dark) return failed(Status::kLeftDark);
  if (right.dark) return failed(Status::kRightDark);
  // A target that is known cannot be what stood elsewhere while it was seen; an unknown one may stand still.
  Found found = match_among(times, left, right, others, !identity_.known(), !others.anywhere);
  StereoMatch& match = found.match;
  if (identity_.known() && match.left < 0 && !left.contours.empty() && !right.contours.empty())
    match.status = Status::kOnlyBackground;
  const auto any = [](const std::vector<bool>& taken) { return std::ranges::find(taken, true) != taken.end(); };
  if (match.left < 0 && (any(others.taken[0]) || any(others.taken[1]))) match.status = Status::kOtherTarget;
  const bool lost = track_.status() == TargetTrack::Status::kLost;
  const bool still = !identity_.known() && is_background(match, left, right);
  const bool whole = left.window == search_area(Side::kLeft) && right.window == search_area(Side::kRight);
  const bool doubtful = match.status == Status::kSeen && whole && !others.unknown && identity_.doubtful(times.pair);
  if (!lost && (still || doubtful)) {
    Found other = match_among(times, left, right, others, false, false, &match);
    const bool replaces = (doubtful && outdoes(other.match, other.candidates, match)) ||
                          (still && may_replace(other.match, match, left, right));
    if (other.match.status == Status::kSeen && replaces) {
      // What appears or moves is more likely the target than what stands still, and what fits best by itself more
      // likely than what was taken for it shortly before, if it is seen repeatedly.
      other.match.status = Status::kOutsidePredictionGate;
      found = std::move(other);
    }
  }
  const bool apart = match.status == Status::kBehindCameras || match.status == Status::kInconsistentPair ||
                     match.status == Status::kEpipolarMismatch;
  if (apart && match.fits_swapped) match.status = Status::kImagesSwapped;
  return found;
}

/// Matches the contours that are no other target, with those in the background or without. Where a confirmed target is
/// expected, a sphere's contour counts also before background of its colour. `followed`: the tracked object, which is
/// compared with the others even if it is unlike the target.
StereoTracker::Found StereoTracker::match_among(const PairTimes& times, const View& left, const View& right,
                                                const OtherTargets& others, bool background, bool predicted,
                                                const StereoMatch* followed) const {
  const auto expected_at = identity_.confirmed() && predicted ? expected_px(times) : std::nullopt;
  const auto is_expected = [&](Side side, const SphereContour& contour) {
    return expected_at && contour.kind == SphereContour::Kind::kEdges &&
           (contour.centre_px - (*expected_at)[index(side)]).norm() < kAround * contour.radius_px;
  };
  std::array<std::vector<SphereContour>, 2> contours;
  std::array<std::vector<int>, 2> from;
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const View& view = side == Side::kLeft ? left : right;
    const std::vector<bool>& taken = others.taken[index(side)];
    for (size_t k = 0; k < view.contours.size(); ++k) {
      if (k < taken.size() && taken[k]) continue;
      if (!background && view.appearance[k].background > kBackgroundShare && !is_expected(side, view.contours[k]))
        continue;
      contours[index(side)].push_back(view.contours[k]);
      // A sphere's contour counts before background of its colour; a blob that is mostly background does not.
      if (view.appearance[k].background > kBackgroundShare) contours[index(side)].back().by_centroid = nullptr;
      from[index(side)].push_back(static_cast<int>(k));
    }
  }
  TargetHistory history = predicted ? history_at(times) : TargetHistory{};
  if (followed && identity_.found_again()) history.radius_m = identity_.appearance(times.pair).radius_m;
  std::optional<Prediction> prediction;
  if (history.agile) prediction = {history.agile->position, history.agile->covariance, history.agile->bias_covariance};
  std::vector<ComparedPair> pairs = compare_pairs(rig_at(times), contours[0], contours[1], prediction, options_.match);
  for (ComparedPair& pair : pairs) {
    if (options_.search_region && is_located(pair.match.status) &&
        !may_be_inside(*options_.search_region, pair.match.point.p_W, pair.match.point.covariance))
      pair.match.status = StereoMatch::Status::kOutsideRegion;
    pair.match.left = from[0][static_cast<size_t>(pair.match.left)];
    pair.match.right = from[1][static_cast<size_t>(pair.match.right)];
    const bool expected = prediction && pair.match.status != StereoMatch::Status::kOutsidePredictionGate;
    if (!expected && is_located(pair.match.status) && are_different_parts(pair, left, right))
      pair.match.status = StereoMatch::Status::kInconsistentPair;
    const bool may_be_target = pair.match.status == StereoMatch::Status::kSeen ||
                               pair.match.status == StereoMatch::Status::kOutsidePredictionGate;
    const bool is_followed = followed && pair.match.left == followed->left && pair.match.right == followed->right;
    if (!expected && may_be_target && !is_followed && !(options_.match.radius_m > 0) &&
        is_unlike(pair, left.appearance[static_cast<size_t>(pair.match.left)],
                  right.appearance[static_cast<size_t>(pair.match.right)], identity_.appearance(times.pair)))
      pair.match.status = StereoMatch::Status::kUnlike;
  }
  Found found;
  found.match = best_match(contours[0], contours[1], pairs);
  found.candidates = candidates_of(pairs, left.appearance, right.appearance, history, options_.match);
  if (found.candidates.empty()) {
    add_occlusion(times.pair, left, right, found.match);
    return found;
  }
  for (size_t k = 0; k < found.candidates.size(); ++k) {
    StereoMatch& match = found.candidates[k].match;
    if (!(options_.match.radius_m > 0) && !match.both_by_contour)
      match.shape_covariance += covariance_of_parts(found.candidates, k);
  }
  const auto chosen = choose(found.candidates, others.sought);
  found.match = found.candidates[chosen.value_or(0)].match;
  if (!chosen) found.match.status = StereoMatch::Status::kAmbiguous;
  const auto located = static_cast<size_t>(std::ranges::count(others.taken[0], true));
  if (chosen && !history.agile) check_first_match(*chosen, pairs, located, left, right, found);
  // After the checks of a first match: it may be another object than the one whose size is remembered.
  add_occlusion(times.pair, left, right, found.match);
  for (Candidate& candidate : found.candidates) add_occlusion(times.pair, left, right, candidate.match);
  return found;
}

/// Adds what may be occluded to the covariance of a match by the area of an object of unknown size. Where the border of
/// an image cuts it off, its covariance has that already.
void StereoTracker::add_occlusion(int64_t utime, const View& left, const View& right, StereoMatch& match) const {
  if (match.both_by_contour || !is_located(match.status) || !tells_size(match, left, right)) return;
  match.shape_covariance += unoccluded_size_.occlusion_covariance(radius_by_area(match, left, right), utime);
}

/// Whether the areas of a match tell how large an object of unknown size is.
bool StereoTracker::tells_size(const StereoMatch& match, const View& left, const View& right) const {
  return !(options_.match.radius_m > 0) && !left.contours[static_cast<size_t>(match.left)].cut_off &&
         !right.contours[static_cast<size_t>(match.right)].cut_off;
}

bool StereoTracker::is_inside_windows(const PairTimes& times, const StereoMatch& match, const View& left,
                                      const View& right) const {
  if (match.status != StereoMatch::Status::kSeen || !track_.expects(times.pair, estimate_at_pair(times, match)))
    return false;
  constexpr int kRead = 10;  // pixels around the blob that the edge measurement reads
  const auto whole = [](const cv::Rect& box, const cv::Rect& window, const cv::Rect& area) {
    return (box.x - kRead >= window.x || window.x == area.x) && (box.y - kRead >= window.y || window.y == area.y) &&
           (box.br().x + kRead <= window.br().x || window.br().x == area.br().x) &&
           (box.br().y + kRead <= window.br().y || window.br().y == area.br().y);
  };
  return whole(left.blobs[static_cast<size_t>(match.left)].box, left.window, search_area(Side::kLeft)) &&
         whole(right.blobs[static_cast<size_t>(match.right)].box, right.window, search_area(Side::kRight));
}

double StereoTracker::radius_by_area(const StereoMatch& match, const View& left, const View& right) const {
  const StereoRig& rig = options_.rig;
  const Eigen::Vector3d p_L = rig.X_WL.inverse() * match.point.p_W;
  const auto radius_m = [](const SphereContour& contour, const CameraModel& camera, double distance_m) {
    return std::sqrt(contour.area / std::numbers::pi / (camera.fx * camera.fy)) * distance_m;
  };
  return std::min(radius_m(left.contours[static_cast<size_t>(match.left)], rig.left, p_L.norm()),
                  radius_m(right.contours[static_cast<size_t>(match.right)], rig.right, (rig.X_RL * p_L).norm()));
}

/// Status to report when a pair was rejected. The track ignores a pair that is not newer and may still be tracked then.
TargetTrack::Status StereoTracker::unseen_status() const {
  return track_.status() == TargetTrack::Status::kTracked ? TargetTrack::Status::kCoasting : track_.status();
}

/// The matched position, moved to the time of the pair; its covariance is that by which the track weighs it, with the
/// unknown motion between exposures.
PositionEstimate StereoTracker::estimate_at_pair(const PairTimes& times, const StereoMatch& match) const {
  PositionEstimate estimate{match.point.p_W, match.noise_covariance(), match.bias_covariance()};
  const bool lost = track_.status() == TargetTrack::Status::kLost;
  const double left = offset_s(times.left, times.pair), later = offset_s(times.right, times.pair) - left;
  if (!lost) estimate.position -= track_.velocity() * left;
  const Eigen::Matrix3d speed2 =
      lost ? (Eigen::Matrix3d::Identity() * kUnknownSpeed * kUnknownSpeed).eval() : track_.velocity_covariance();
  estimate.covariance += speed2 * left * left;
  // A motion e across the line of sight between the exposures looks like an error e Z / B along it.
  const Eigen::Vector3d line = options_.rig.X_WL.linear() * (options_.rig.X_WL.inverse() * match.point.p_W);
  const double ratio = line.norm() / options_.rig.baseline_m();
  const Eigen::Vector3d along = line.normalized();
  estimate.covariance += along * along.transpose() * (speed2.trace() / 3 * later * later * ratio * ratio);
  return estimate;
}

TargetReport StereoTracker::report(TargetTrack::Status status, const char* reason) const {
  const PositionEstimate estimate = track_.estimate();
  return {.status = status,
          .estimate = {estimate.position, estimate.covariance + estimate.bias_covariance + shape_covariance_},
          .velocity = track_.velocity(),
          .velocity_covariance = track_.velocity_covariance(),
          .last_seen_utime = track_.last_seen_utime(),
          .reason = reason};
}

TargetReport StereoTracker::update_unseen(int64_t utime, const char* reason) {
  track_.update(utime, std::nullopt);
  identity_.update_unseen(utime, track_.status() == TargetTrack::Status::kLost);
  for (CameraState& camera_state : cameras_) camera_state.gains = relaxed(camera_state.gains);
  return report(unseen_status(), reason);
}

TargetReport StereoTracker::update(const PairTimes& times, const StereoMatch& match, const View& left,
                                   const View& right, const std::array<std::vector<cv::Rect>, 2>& others) {
  const bool newer = !track_.begun() || times.pair > track_.utime();
  TargetReport result = update_track(times, match, left, right, others);
  if (newer) {
    const bool followed = result.status == TargetTrack::Status::kTracked;
    if (followed) calibration_.update(match);
    notice_motion(Side::kLeft, left, times.pair);
    notice_motion(Side::kRight, right, times.pair);
    // What the track has not accepted may be the target that jumps, until further matches tell.
    const bool may_be_target = followed || match.status == StereoMatch::Status::kSeen ||
                               match.status == StereoMatch::Status::kOutsidePredictionGate;
    learn_background(Side::kLeft, left, may_be_target ? match.left : -1, others[0]);
    learn_background(Side::kRight, right, may_be_target ? match.right : -1, others[1]);
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
void StereoTracker::learn_background(Side side, const View& view, int chosen, std::vector<cv::Rect> objects) {
  CameraState& camera_state = cameras_[index(side)];
  if (!view.fits || view.filled || view.dark || view.wider) return;
  cv::Rect object;
  if (identity_.confirmed() && chosen >= 0) object = view.blobs[static_cast<size_t>(chosen)].box;
  if (identity_.known() && identity_.last_radius_px() > 0) {
    const Eigen::Vector2d centre = identity_.last_px(index(side));
    const double half = kAround * identity_.last_radius_px();
    object |= cv::Rect(static_cast<int>(centre.x() - half), static_cast<int>(centre.y() - half),
                       static_cast<int>(2 * half) + 1, static_cast<int>(2 * half) + 1);
  }
  objects.push_back(object);
  const bool whole = view.window == search_area(side);
  camera_state.background.learn(view.window, view.blobs, objects, whole ? camera_state.since_look + 1 : 1);
  camera_state.since_look = whole ? 0 : std::min(kLookEvery, camera_state.since_look + 1);
  if (whole) camera_state.looks = std::min(kFirstLooks, camera_state.looks + 1);
}

TargetReport StereoTracker::update_track(const PairTimes& times, const StereoMatch& match, const View& left,
                                         const View& right, const std::array<std::vector<cv::Rect>, 2>& others) {
  using Status = StereoMatch::Status;
  if (track_.begun() && times.pair <= track_.utime())
    return report(unseen_status(), "the pair is not newer than the last one");
  // A match away from the prediction may be a jump: the track accepts it once further matches confirm it, or at once.
  const bool seen = match.status == Status::kSeen || match.status == Status::kOutsidePredictionGate;
  // A mostly occluded target is measured poorly: good enough to continue a track, not to start one.
  const bool partly = (match.status == Status::kOccludedTooMuch || match.status == Status::kCutOff) &&
                      match.occlusion < BlobCentre::kNotLocated && match.left >= 0 && match.right >= 0 &&
                      track_.status() != TargetTrack::Status::kLost;
  if (!seen && !partly) {
    TargetReport unseen = update_unseen(times.pair, description(match.status));
    unseen.ambiguous = match.status == Status::kAmbiguous;
    return unseen;
  }
  const PositionEstimate estimate = estimate_at_pair(times, match);
  using Jump = TargetTrack::Jump;
  const Jump jump = !seen                                                           ? Jump::kNever
                    : has_bounced(times.pair, estimate, match, left, right, others) ? Jump::kAtOnce
                                                                                    : Jump::kIfConfirmed;
  if (!track_.update(times.pair, estimate, jump)) {
    identity_.update_unseen(times.pair, track_.status() == TargetTrack::Status::kLost);
    return report(unseen_status(), description(Status::kOutsidePredictionGate));
  }
  shape_covariance_ = match.shape_covariance.selfadjointView<Eigen::Lower>();  // exactly symmetric, as is restored
  if (partly) return report(TargetTrack::Status::kCoasting, description(match.status));
  TargetReport tracked = report(TargetTrack::Status::kTracked, description_of_seen(match, options_.match));
  tracked.estimate = {estimate.position, estimate.covariance + shape_covariance_};
  // What only the wider colours show teaches nothing about the target.
  if (left.wider || right.wider) return tracked;
  if (tells_size(match, left, right)) unoccluded_size_.update(radius_by_area(match, left, right), times.pair);
  const Eigen::Vector3d p_L = options_.rig.X_WL.inverse() * match.point.p_W;
  radius_m_ = options_.match.radius_m > 0 ? options_.match.radius_m
                                          : left.contours[static_cast<size_t>(match.left)].value.z() * p_L.norm();
  const auto l = static_cast<size_t>(match.left), r = static_cast<size_t>(match.right);
  const double compactness = std::min(left.appearance[l].compactness, right.appearance[r].compactness);
  const double radius_px = std::min(left.contours[l].radius_px, right.contours[r].radius_px);
  identity_.update(
      times.pair,
      {.by_contour = match.both_by_contour,
       .convincing = is_convincing(match, radius_px, left.appearance[l], right.appearance[r]),
       .px = {match.left_px, match.right_px},
       .radius_px = radius_px,
       .appearance = tells_size(match, left, right) ? TargetAppearance{radius_m_, compactness} : TargetAppearance{},
       .background = {left.appearance[l].background, right.appearance[r].background}},
      track_.began_anew());
  // What is not known to be the target must not change its colour.
  if (options_.adapt_colour && identity_.confirmed()) {
    // Without a sphere contour the blob may include other things: adapt more slowly.
    const double quality = match.both_by_contour ? 1 - match.occlusion : 0.5;
    adapt(Side::kLeft, left, match.left, quality);
    adapt(Side::kRight, right, match.right, quality);
  }
  return tracked;
}

void StereoTracker::adapt(Side side, const View& view, int chosen, double quality) {
  CameraState& camera_state = cameras_[index(side)];
  const IlluminationSample sample =
      camera_state.model.sample(camera_state.gains, view.bgr, view.blobs[static_cast<size_t>(chosen)]);
  camera_state.gains = adapted(camera_state.gains, sample, quality);
}

StereoTracker::Found StereoTracker::find(const cv::Mat& left_bgr, const cv::Mat& right_bgr, bool chroma_subsampled) {
  const View left = measure(Side::kLeft, left_bgr, search_area(Side::kLeft), chroma_subsampled);
  const View right = measure(Side::kRight, right_bgr, search_area(Side::kRight), chroma_subsampled);
  return match({}, left, right);
}

}  // namespace multireach::vision
