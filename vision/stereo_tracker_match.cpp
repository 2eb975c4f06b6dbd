// Which of the contours in two images are the target.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "vision/stereo/compare_contours.hpp"
#include "vision/stereo_tracker.hpp"

namespace multireach::vision {
namespace {

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

/// Whether a match has a position that can be compared with the search region.
bool is_located(StereoMatch::Status status) {
  using Status = StereoMatch::Status;
  return status == Status::kSeen || status == Status::kOccludedTooMuch || status == Status::kCutOff ||
         status == Status::kWrongRadius || status == Status::kOutsidePredictionGate;
}

constexpr double kExpectedRadii = 2;  // of a contour, from where the target is expected to its centre: a choice

bool is_background(const StereoMatch& match, const View& left, const View& right) {
  return match.left >= 0 && match.right >= 0 && left.appearance[static_cast<size_t>(match.left)].is_background() &&
         right.appearance[static_cast<size_t>(match.right)].is_background();
}

}  // namespace

/// Compensates the target's motion between the two exposures: shifts the right camera by the opposite motion, so that
/// both images show the target at the time of the left one.
StereoRig StereoTracker::rig_at(const PairTimes& times) const {
  StereoRig rig = options_.rig;
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
  Found found =
      match_among(times, left, right, others, {.background = !identity_.known(), .prediction = !others.anywhere});
  StereoMatch& match = found.match;
  const bool outside = match.status == Status::kOutsidePredictionGate && !others.unknown;
  // The gate of the track, unlike that of a match, allows for the errors of its velocity between the exposures.
  if (outside && !track_.expects(times.pair, estimate_at_pair(times, match)))
    found = match_elsewhere(times, left, right, others);
  if (identity_.known() && match.left < 0 && !left.contours.empty() && !right.contours.empty())
    match.status = Status::kOnlyBackground;
  const auto any = [](const std::vector<bool>& taken) { return std::ranges::find(taken, true) != taken.end(); };
  if (match.left < 0 && (any(others.taken[0]) || any(others.taken[1]))) match.status = Status::kOtherTarget;
  const bool lost = track_.status() == TargetTrack::Status::kLost;
  const bool still = !identity_.known() && is_background(match, left, right);
  const bool whole = left.window == search_area(Side::kLeft) && right.window == search_area(Side::kRight);
  const bool doubtful = match.status == Status::kSeen && whole && !others.unknown && identity_.doubtful(times.pair);
  if (!lost && (still || doubtful)) {
    const double lead = doubtful && identity_.found_again() ? lead_against_found_again() : kLead;
    Found other = match_among(times, left, right, others, {.followed = &match, .lead = lead});
    const bool replaces = (doubtful && outdoes(other.match, other.candidates, match)) ||
                          (still && may_replace(other.match, match, left, right));
    if (other.match.status == Status::kSeen && replaces) {
      // What appears or moves is more likely the target than what stands still, and what fits best by itself more
      // likely than what was taken for it shortly before, if it is seen repeatedly.
      other.match.status = Status::kOutsidePredictionGate;
      other.candidates.front().chosen = false;
      other.candidates.front().reason = "it replaces the followed object if further matches confirm it";
      other.replaces = match;
      found = std::move(other);
    }
  }
  const bool apart = match.status == Status::kBehindCameras || match.status == Status::kInconsistentPair ||
                     match.status == Status::kEpipolarMismatch;
  if (apart && match.fits_swapped) match.status = Status::kImagesSwapped;
  return found;
}

/// Matches what is not where the target is expected, which may have jumped there: it is as uncertain as a first match.
StereoTracker::Found StereoTracker::match_elsewhere(const PairTimes& times, const View& left, const View& right,
                                                    const OtherTargets& others) const {
  using Status = StereoMatch::Status;
  OtherTargets among = others;
  among.sought = others.sought_elsewhere;
  Found found = match_among(times, left, right, among, {.background = !identity_.known()});
  if (found.match.status == Status::kAmbiguous) found.match.status = Status::kSeveralElsewhere;
  if (found.match.status != Status::kSeen) return found;
  found.match.status = Status::kOutsidePredictionGate;
  found.candidates.front().chosen = false;
  found.candidates.front().reason = "it is not where the target is expected: further matches must confirm it";
  return found;
}

/// Matches the contours that are no other target. Where a confirmed target is expected, a sphere's contour counts also
/// before background of its colour.
StereoTracker::Found StereoTracker::match_among(const PairTimes& times, const View& left, const View& right,
                                                const OtherTargets& others, const MatchScope& scope) const {
  const auto expected_at = identity_.confirmed() && scope.prediction ? expected_px(times) : std::nullopt;
  const auto is_expected = [&](Side side, const SphereContour& contour) {
    return expected_at && contour.kind == SphereContour::Kind::kEdges &&
           (contour.centre_px - (*expected_at)[index(side)]).norm() < kExpectedRadii * contour.radius_px;
  };
  std::array<std::vector<SphereContour>, 2> contours;
  std::array<std::vector<int>, 2> from;
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const View& view = side == Side::kLeft ? left : right;
    const std::vector<bool>& taken = others.taken[index(side)];
    for (size_t k = 0; k < view.contours.size(); ++k) {
      if (k < taken.size() && taken[k]) continue;
      if (!scope.background && view.appearance[k].is_background() && !is_expected(side, view.contours[k])) continue;
      contours[index(side)].push_back(view.contours[k]);
      // A sphere's contour counts before background of its colour; a blob that is mostly background does not.
      if (view.appearance[k].is_background()) contours[index(side)].back().by_centroid = nullptr;
      from[index(side)].push_back(static_cast<int>(k));
    }
  }
  TargetHistory history = scope.prediction ? history_at(times) : TargetHistory{};
  if (scope.followed && identity_.found_again()) history.radius_m = identity_.appearance(times.pair).radius_m;
  std::optional<Prediction> prediction;
  if (history.manoeuvring)
    prediction = {history.manoeuvring->position, history.manoeuvring->covariance, history.manoeuvring->bias_covariance};
  const bool moves = prediction.has_value();  // not known of what is lost, or seen elsewhere
  std::vector<ComparedPair> pairs =
      compare_pairs(moves ? rig_at(times) : options_.rig, contours[0], contours[1], prediction, options_.match);
  const auto is_followed = [&](const ComparedPair& pair) {
    return scope.followed && from[0][static_cast<size_t>(pair.match.left)] == scope.followed->left &&
           from[1][static_cast<size_t>(pair.match.right)] == scope.followed->right;
  };
  for (ComparedPair& pair : pairs) {
    const bool followed = is_followed(pair);
    if (followed) {
      // Its motion is known: its images fit each other where it has moved between the exposures.
      const int l = pair.match.left, r = pair.match.right;
      const bool mixed = pair.mixed;
      pair = compare_contours(rig_at(times), contours[0][static_cast<size_t>(l)], contours[1][static_cast<size_t>(r)],
                              prediction, options_.match);
      pair.match.left = l;
      pair.match.right = r;
      pair.mixed = mixed;
    }
    pair.match.unknown_motion = !moves && !followed;
    if (options_.search_region && is_located(pair.match.status) &&
        !may_be_inside(*options_.search_region, pair.match.point.p_W, pair.match.point.covariance))
      pair.match.status = StereoMatch::Status::kOutsideRegion;
    pair.match.left = from[0][static_cast<size_t>(pair.match.left)];
    pair.match.right = from[1][static_cast<size_t>(pair.match.right)];
    const bool expected = prediction && !pair.outside_gate;
    if (!expected && is_located(pair.match.status) && are_different_parts(pair, left, right))
      pair.match.status = StereoMatch::Status::kInconsistentPair;
    const bool may_be_target = pair.match.status == StereoMatch::Status::kSeen ||
                               pair.match.status == StereoMatch::Status::kOutsidePredictionGate;
    if (!may_be_target || followed) continue;
    const Appearance& in_left = left.appearance[static_cast<size_t>(pair.match.left)];
    const Appearance& in_right = right.appearance[static_cast<size_t>(pair.match.right)];
    const bool known_size = options_.match.radius_m > 0;
    if (is_off_colour(pair, in_left, in_right))
      pair.match.status = StereoMatch::Status::kOffColour;
    else if (!known_size && (expected ? is_smear(pair, in_left, in_right, identity_.appearance(times.pair))
                                      : is_unlike(pair, in_left, in_right, identity_.appearance(times.pair))))
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
  const auto chosen = choose(found.candidates, others.sought, scope.lead);
  found.match = found.candidates[chosen.value_or(0)].match;
  if (!chosen) found.match.status = StereoMatch::Status::kAmbiguous;
  const auto located = static_cast<size_t>(std::ranges::count(others.taken[0], true));
  if (chosen && !history.manoeuvring) check_first_match(*chosen, pairs, located, left, right, found);
  // After the checks of a first match: it may be another object than the one whose size is remembered.
  add_occlusion(times.pair, left, right, found.match);
  for (Candidate& candidate : found.candidates) add_occlusion(times.pair, left, right, candidate.match);
  return found;
}

/// Adds what may be occluded to the covariance of a match by the area of an object of unknown size. Where the border of
/// an image cuts it off, its covariance has that already. A contour that is much smaller than the object is that of a
/// round piece of it, as between the fingers of a hand.
void StereoTracker::add_occlusion(int64_t utime, const View& left, const View& right, StereoMatch& match) const {
  if (!is_located(match.status) || !tells_size(match, left, right)) return;
  if (match.both_by_contour) {
    const double radius_m = radius_by_contour(match, left, right);
    if (options_.match.max_size_ratio * radius_m < unoccluded_size_.radius_m())
      match.shape_covariance += unoccluded_size_.occlusion_covariance(radius_m, utime);
    return;
  }
  const double radius_m = radius_by_area(match, left, right);
  match.shape_covariance += unoccluded_size_.occlusion_covariance(radius_m, utime);
  // The wider colours may also show some of what is beside the object.
  if (left.wider || right.wider) match.shape_covariance += unoccluded_size_.surplus_covariance(radius_m);
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
  const Eigen::Vector3d p_L = options_.rig.X_WL.inverse() * match.point.p_W;
  const auto radius_m = [](const SphereContour& contour, const CameraModel& camera, double distance_m) {
    return std::sqrt(contour.area / std::numbers::pi / (camera.fx * camera.fy)) * distance_m;
  };
  return std::min(
      radius_m(left.contours[static_cast<size_t>(match.left)], options_.rig.left, p_L.norm()),
      radius_m(right.contours[static_cast<size_t>(match.right)], options_.rig.right, (options_.rig.X_RL * p_L).norm()));
}

double StereoTracker::radius_by_contour(const StereoMatch& match, const View& left, const View& right) const {
  const Eigen::Vector3d p_L = options_.rig.X_WL.inverse() * match.point.p_W;
  return std::min(left.contours[static_cast<size_t>(match.left)].value.z() * p_L.norm(),
                  right.contours[static_cast<size_t>(match.right)].value.z() * (options_.rig.X_RL * p_L).norm());
}

}  // namespace multireach::vision
