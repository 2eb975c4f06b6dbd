#include "vision/matching/match_pair.hpp"

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "vision/colour/grow_blobs.hpp"
#include "vision/matching/first_match.hpp"
#include "vision/matching/jumps.hpp"
#include "vision/matching/matched_size.hpp"
#include "vision/stereo/compare_contours.hpp"
#include "vision/track/object_prediction.hpp"

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

/// Whether a pair combines what grew (grow_blobs) with a part that did not.
bool is_whole_and_part(const ComparedPair& pair, const View& left, const View& right) {
  const auto grew = [](const View& view, int at) { return !view.wider() && view.shows_more_than_learned(at); };
  const auto is_part = [](const View& view, int at) {
    const auto k = static_cast<size_t>(at);
    return view.contours[k].kind == SphereContour::Kind::kCentroid && has_low_compactness(view.blobs[k]);
  };
  const auto both = [&](const View& whole, int whole_at, const View& part, int part_at) {
    return grew(whole, whole_at) && is_part(part, part_at);
  };
  return both(left, pair.match.left, right, pair.match.right) || both(right, pair.match.right, left, pair.match.left);
}

constexpr double kExpectedRadii = 2;  // of a contour, from where the target is expected to its centre: a choice

bool is_background(const StereoMatch& match, const View& left, const View& right) {
  return match.left >= 0 && match.right >= 0 && left.appearance[static_cast<size_t>(match.left)].is_background() &&
         right.appearance[static_cast<size_t>(match.right)].is_background();
}

/// The steps of match_pair().
class PairMatcher {
 public:
  explicit PairMatcher(const PairContext& pair) : pair_(pair), options_(pair.options), object_(pair.object) {}

  TargetMatch match(const OtherTargets& others) const;

 private:
  /// What takes part in a match.
  struct Scope {
    bool background = false;                ///< contours that the remembered background explains
    bool prediction = false;                ///< the target's motion
    const StereoMatch* followed = nullptr;  ///< the tracked object, even if it is unlike the target; null: none
    double lead = kLead;                    ///< evidence by which the best candidate must exceed the others
  };
  /// The contours of an image that take part, and their numbers in the view.
  struct Contours {
    std::vector<SphereContour> contours;
    std::vector<int> numbers;
  };

  TargetMatch match_elsewhere(const OtherTargets& others) const;
  TargetMatch match_among(const OtherTargets& others, const Scope& scope) const;
  std::optional<TargetMatch> match_instead_of(const StereoMatch& match, const OtherTargets& others) const;
  std::array<Contours, 2> contours_among(const OtherTargets& others, const Scope& scope) const;
  std::vector<ComparedPair> compare(const std::array<Contours, 2>& among, const TargetHistory& history,
                                    const Scope& scope, size_t sought) const;
  void admit_at_border(size_t sought, std::vector<ComparedPair>& pairs) const;
  void refuse_unlike(bool expected, ComparedPair& compared) const;
  bool is_whole_target(const StereoMatch& match) const;
  double lead_against_found_again() const;

  const PairContext& pair_;
  const TrackerOptions& options_;
  const TrackedObject& object_;
};

TargetMatch PairMatcher::match(const OtherTargets& others) const {
  using Status = StereoMatch::Status;
  const auto failed = [](Status status) {
    TargetMatch found;
    found.match.status = status;
    return found;
  };
  using Content = View::Content;
  const auto any_is = [&](Content content) { return pair_.left.content == content || pair_.right.content == content; };
  if (any_is(Content::kWrongImage)) return failed(Status::kWrongImageSize);
  if (any_is(Content::kFilled)) return failed(Status::kColourEverywhere);
  if (pair_.left.content == Content::kDark) return failed(Status::kLeftDark);
  if (pair_.right.content == Content::kDark) return failed(Status::kRightDark);
  const bool known = object_.identity.known();
  // A target that is known cannot be what stood elsewhere while it was seen; an unknown one may stand still.
  TargetMatch found = match_among(others, {.background = !known, .prediction = !others.anywhere});
  StereoMatch& match = found.match;
  const bool outside = match.status == Status::kOutsidePredictionGate && !others.unknown;
  // The gate of the track, unlike that of a match, allows for the errors of its velocity between the exposures.
  if (outside && !object_.track.expects(pair_.times.pair, estimate_at_pair(options_, object_, pair_.times, match)))
    found = match_elsewhere(others);
  if (known && match.left < 0 && !pair_.left.contours.empty() && !pair_.right.contours.empty())
    match.status = Status::kOnlyBackground;
  const auto any = [](const std::vector<bool>& taken) { return std::ranges::find(taken, true) != taken.end(); };
  if (match.left < 0 && (any(others.taken[0]) || any(others.taken[1]))) match.status = Status::kOtherTarget;
  if (auto other = match_instead_of(match, others)) found = std::move(*other);
  const bool apart = match.status == Status::kBehindCameras || match.status == Status::kInconsistentPair ||
                     match.status == Status::kEpipolarMismatch;
  if (apart && match.fits_swapped) match.status = Status::kImagesSwapped;
  return found;
}

/// What replaces the matched thing, if further matches confirm it: what appears or moves is more likely the target than
/// what stands still, and what fits best by itself more likely than what was taken for it shortly before, also where
/// the border now cuts off too much of that.
std::optional<TargetMatch> PairMatcher::match_instead_of(const StereoMatch& match, const OtherTargets& others) const {
  using Status = StereoMatch::Status;
  const TargetIdentity& identity = object_.identity;
  if (object_.track.status() == TargetTrack::Status::kLost) return std::nullopt;
  const bool still = !identity.known() && is_background(match, pair_.left, pair_.right);
  const bool may_doubt =
      pair_.left.whole && pair_.right.whole && !others.unknown && identity.doubtful(pair_.times.pair);
  const bool doubtful = may_doubt && match.status == Status::kSeen;
  const bool leaves = may_doubt && match.status == Status::kCutOff;
  if (!still && !doubtful && !leaves) return std::nullopt;
  const double lead = doubtful && identity.found_again() ? lead_against_found_again() : kLead;
  TargetMatch other = match_among(others, {.followed = &match, .lead = lead});
  if (other.match.status != Status::kSeen) return std::nullopt;
  const bool replaces = (doubtful && outdoes(other.match, other.candidates, match)) ||
                        (leaves && is_whole_target(other.match) && are_apart(other.match, match)) ||
                        (still && may_replace(pair_, other.match, match));
  if (!replaces) return std::nullopt;
  other.match.status = Status::kOutsidePredictionGate;
  other.candidates.front().chosen = false;
  other.candidates.front().reason = "it replaces the followed object if further matches confirm it";
  other.replaces = match;
  return other;
}

/// Whether what both images show of a match is like a target, and not what the border has left of something.
bool PairMatcher::is_whole_target(const StereoMatch& match) const {
  const auto l = static_cast<size_t>(match.left), r = static_cast<size_t>(match.right);
  const SphereContour &left = pair_.left.contours[l], &right = pair_.right.contours[r];
  return !left.is_cut_off_blob() && !right.is_cut_off_blob() &&
         is_convincing(match, std::min(left.radius_px, right.radius_px), pair_.left.appearance[l],
                       pair_.right.appearance[r]);
}

/// Evidence by which another thing must exceed what was found again, in each of the pairs that confirm the jump: as
/// much in their sum as a single choice takes, or two thirds of it where a near jump takes two pairs. More than three
/// successive pairs hardly show more than three.
double PairMatcher::lead_against_found_again() const {
  return kLead / std::clamp(options_.track.confirmations, 1, 3);
}

/// Matches what is not where the target is expected, which may have jumped there: it is as uncertain as a first match.
TargetMatch PairMatcher::match_elsewhere(const OtherTargets& others) const {
  using Status = StereoMatch::Status;
  OtherTargets among = others;
  among.sought = others.sought_elsewhere;
  TargetMatch found = match_among(among, {.background = !object_.identity.known()});
  if (found.match.status == Status::kAmbiguous) found.match.status = Status::kSeveralElsewhere;
  if (found.match.status != Status::kSeen) return found;
  found.match.status = Status::kOutsidePredictionGate;
  found.candidates.front().chosen = false;
  found.candidates.front().reason = "it is not where the target is expected: further matches must confirm it";
  return found;
}

/// Matches the contours that are no other target.
TargetMatch PairMatcher::match_among(const OtherTargets& others, const Scope& scope) const {
  const std::array<Contours, 2> among = contours_among(others, scope);
  TargetHistory history = scope.prediction ? history_at(options_, object_, pair_.times) : TargetHistory{};
  if (scope.followed && object_.identity.found_again())
    history.radius_m = object_.identity.appearance(pair_.times.pair).radius_m;
  const std::vector<ComparedPair> pairs = compare(among, history, scope, others.sought);
  TargetMatch found;
  found.match = best_match(among[0].contours, among[1].contours, pairs);
  found.candidates = candidates_of(pairs, pair_.left.appearance, pair_.right.appearance, history, options_.match);
  if (found.candidates.empty()) {
    add_occlusion_covariance(pair_, found.match);
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
  const auto others_in_left = static_cast<size_t>(std::ranges::count(others.taken[0], true));
  if (chosen && !history.manoeuvring) refuse_unlikely_first_match(pair_, *chosen, pairs, others_in_left, found);
  // After the checks of a first match: it may be another object than the one whose size is remembered.
  add_occlusion_covariance(pair_, found.match);
  for (Candidate& candidate : found.candidates) add_occlusion_covariance(pair_, candidate.match);
  return found;
}

/// The contours that are no other target and, unless `scope` has the background, none of it: but where a confirmed
/// target is expected, a sphere's contour counts even there.
std::array<PairMatcher::Contours, 2> PairMatcher::contours_among(const OtherTargets& others, const Scope& scope) const {
  const auto expected_at =
      object_.identity.confirmed() && scope.prediction ? predicted_px(options_, object_, pair_.times) : std::nullopt;
  const auto is_expected = [&](Side side, const SphereContour& contour) {
    return expected_at && contour.kind == SphereContour::Kind::kEdges &&
           (contour.centre_px - (*expected_at)[index(side)]).norm() < kExpectedRadii * contour.radius_px;
  };
  std::array<Contours, 2> among;
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const View& view = side == Side::kLeft ? pair_.left : pair_.right;
    const std::vector<bool>& taken = others.taken[index(side)];
    auto& [contours, numbers] = among[index(side)];
    for (size_t k = 0; k < view.contours.size(); ++k) {
      if (k < taken.size() && taken[k]) continue;
      const bool background = view.appearance[k].is_background();
      if (!scope.background && background && !is_expected(side, view.contours[k])) continue;
      contours.push_back(view.contours[k]);
      // The centroid of a blob that is mostly background must not replace the contour.
      if (background) contours.back().by_centroid = nullptr;
      numbers.push_back(static_cast<int>(k));
    }
  }
  return among;
}

/// Compares all pairs of contours, and refuses those that are not the target. The numbers of their contours are those
/// in the views.
std::vector<ComparedPair> PairMatcher::compare(const std::array<Contours, 2>& among, const TargetHistory& history,
                                               const Scope& scope, size_t sought) const {
  std::optional<Prediction> prediction;
  if (history.manoeuvring)
    prediction = {history.manoeuvring->position, history.manoeuvring->covariance, history.manoeuvring->bias_covariance};
  const bool moves = prediction.has_value();  // not known of what is lost, or seen elsewhere
  const auto moved_rig = [&] { return motion_compensated_rig(options_, object_, pair_.times); };
  std::vector<ComparedPair> pairs = compare_pairs(moves ? moved_rig() : options_.rig, among[0].contours,
                                                  among[1].contours, prediction, options_.match);
  for (ComparedPair& compared : pairs) {
    const auto l = static_cast<size_t>(compared.match.left), r = static_cast<size_t>(compared.match.right);
    const int in_left = among[0].numbers[l], in_right = among[1].numbers[r];
    const bool followed = scope.followed && in_left == scope.followed->left && in_right == scope.followed->right;
    if (followed) {
      // Its motion is known: its images fit each other where it has moved between the exposures.
      const bool mixed = compared.mixed;
      compared = compare_contours(moved_rig(), among[0].contours[l], among[1].contours[r], prediction, options_.match);
      compared.mixed = mixed;
      if (compared.cut_off_blob) compared.match.status = StereoMatch::Status::kSeen;
    }
    compared.match.unknown_motion = !moves && !followed;
    compared.match.left = in_left;
    compared.match.right = in_right;
    if (options_.search_region && has_position(compared.match.status) &&
        !may_be_inside(*options_.search_region, compared.match.point.p_W, compared.match.point.covariance))
      compared.match.status = StereoMatch::Status::kOutsideRegion;
    const bool expected = prediction && !compared.outside_gate;
    if (!expected && has_position(compared.match.status) && are_different_parts(compared, pair_.left, pair_.right))
      compared.match.status = StereoMatch::Status::kInconsistentPair;
    if (has_position(compared.match.status) && is_whole_and_part(compared, pair_.left, pair_.right))
      compared.match.status = StereoMatch::Status::kInconsistentPair;
    if (!followed) refuse_unlike(expected, compared);
  }
  // What is followed is not replaced by what may be a part of anything.
  if (!scope.followed) admit_at_border(sought, pairs);
  return pairs;
}

/// Admits what the border cuts off where no prediction supports it, if it is large and compact, and no more than
/// `sought` things at the border may be the target. It may be a part of anything: of a target that was seen lately, the
/// size must be remembered, and it must not be larger; of one of known radius, a sphere's contour must be seen.
void PairMatcher::admit_at_border(size_t sought, std::vector<ComparedPair>& pairs) const {
  using Status = StereoMatch::Status;
  if (options_.match.radius_m > 0) return;
  const double seen_m = object_.identity.appearance(pair_.times.pair).radius_m;
  std::vector<int> things;  // contours of the left image, of what may be the target
  std::vector<ComparedPair*> admitted;
  for (ComparedPair& pair : pairs) {
    if (pair.match.status != Status::kCutOff) continue;
    const Appearance& in_left = pair_.left.appearance[static_cast<size_t>(pair.match.left)];
    const Appearance& in_right = pair_.right.appearance[static_cast<size_t>(pair.match.right)];
    const bool larger = object_.identity.known() && !(pair.radius_m < options_.match.max_size_ratio * seen_m);
    if (larger || is_off_colour(pair, in_left, in_right)) continue;
    if (!is_likely(pair.match, pair.radius_px, in_left, in_right)) continue;
    if (std::ranges::find(things, pair.match.left) == things.end()) things.push_back(pair.match.left);
    if (pair.cut_off_blob && may_start_at_border(pair.match, pair.radius_px, in_left, in_right))
      admitted.push_back(&pair);
  }
  if (things.size() > sought) return;
  for (ComparedPair* pair : admitted) {
    pair->match.status = Status::kSeen;
    refuse_unlike(false, *pair);
  }
}

/// Refuses what may be the target by its position, but looks otherwise. `expected`: it is where the target is expected.
void PairMatcher::refuse_unlike(bool expected, ComparedPair& compared) const {
  using Status = StereoMatch::Status;
  const Appearance& in_left = pair_.left.appearance[static_cast<size_t>(compared.match.left)];
  const Appearance& in_right = pair_.right.appearance[static_cast<size_t>(compared.match.right)];
  if (compared.match.status != Status::kSeen && compared.match.status != Status::kOutsidePredictionGate) return;
  const bool known_size = options_.match.radius_m > 0;
  const TargetAppearance target = object_.identity.appearance(pair_.times.pair);
  if (is_off_colour(compared, in_left, in_right))
    compared.match.status = Status::kOffColour;
  else if (!known_size &&
           (expected ? is_smear(compared, in_left, in_right, target) : is_unlike(compared, in_left, in_right, target)))
    compared.match.status = Status::kUnlike;
}

}  // namespace

TargetMatch match_pair(const PairContext& pair, const OtherTargets& others) {
  return PairMatcher(pair).match(others);
}

}  // namespace multireach::vision
