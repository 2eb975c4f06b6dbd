#include "vision/track/candidates.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "numeric/natural_log.hpp"
#include "vision/stereo/compare_contours.hpp"

namespace multireach::vision {
namespace {

using Status = StereoMatch::Status;

// Log odds of the labelled balls among all candidates of an image, by conditional logistic regression on the videos
// that docs/real-images.md names for tuning, except kContour and kLargeArea: docs/vision-association.md, Which object.
constexpr double kStill[] = {0, -4.2, -6.2};  // share of remembered background 0, 0.3 and 1
constexpr double kShape[] = {-4.0, 0, 2.3};   // compactness 0, kNoShape and 1
constexpr double kNoShape = 0.6;              // speaks neither for nor against a target
constexpr double kContour = 2.4;              // both images show a sphere contour
constexpr double kColour[] = {-2.8, 0, 0.2};  // share well inside the colour model 0, 0.2 and 1
constexpr double kArea = 2;                   // per logarithm of the area, up to that of kLargeArea; 1 beyond
constexpr double kLargeArea = 300;            // pixels
// Evidence by shape, colour and area of a first match: on the same videos, 4 of 105 targets have less, and 7 of 14
// other things.
constexpr double kLikely = 6.5;
// Shares of the target's radius and compactness (an ellipse of 5:2 has 0.4 of a disc's), choices. On these videos and
// five with things pasted into photographs, 1 of 57 targets that were found again had less of one of them, and all of
// 16 other things that were taken for them.
constexpr double kSmaller = 0.5, kRagged = 0.4;
constexpr double kLeastFit = -0.5 * 16.27;  // of rows, sizes and a known radius: 99.9 % of chi^2, three degrees
constexpr double kGates = 3;                // standard deviations that the gates of MatchOptions stand for
constexpr double kContourSize = 0.04;       // share of a known radius: kSizeError of stereo/compare_contours.cpp

double squared(double value) {
  return value * value;
}

/// Piecewise linear: `at`[0] at 0, `at`[1] at `knee`, `at`[2] at 1.
double interpolated(double value, double knee, const double (&at)[3]) {
  const double x = std::clamp(value, 0.0, 1.0);
  return x < knee ? at[0] + (at[1] - at[0]) * x / knee : at[1] + (at[2] - at[1]) * (x - knee) / (1 - knee);
}

/// Among large things less is known; if their areas are distributed like 1 / a^2 (an assumption), and those of targets
/// like 1 / a, as of a thing at any distance, the likelihood ratio is proportional to the area a.
double by_area(double radius_px) {
  const double area = std::numbers::pi * radius_px * radius_px, small = std::clamp(area, 1.0, kLargeArea);
  return kArea * natural_log(small) + natural_log(std::max(1.0, area / kLargeArea));
}

/// Evidence from one image alone.
double appearance_evidence(const SphereContour& contour, const Appearance& appearance, const MatchOptions& options) {
  const bool edges = contour.kind == SphereContour::Kind::kEdges;
  // A target that enters slowly is partly remembered as background: only what is explained beyond kExplained speaks
  // against what the border cuts off. Among candidates, of which one is chosen, all of it does: otherwise what stands
  // at the border is taken for the target.
  constexpr double kExplained = ColourBackground::kExplained;
  const double still =
      contour.cut_off ? (appearance.background - kExplained) / (1 - kExplained) : appearance.background;
  return interpolated(still, 0.3, kStill) +
         (edges ? kContour : interpolated(appearance.compactness, kNoShape, kShape)) +
         interpolated(appearance.colour_share, 0.2, kColour) + (options.radius_m > 0 ? 0 : by_area(contour.radius_px));
}

double roundness(const StereoMatch& match, const Appearance& left, const Appearance& right) {
  if (match.both_by_contour) return kContour;
  return interpolated(std::min(left.compactness, right.compactness), kNoShape, kShape);
}

double colour(const Appearance& left, const Appearance& right) {
  return interpolated(std::min(left.colour_share, right.colour_share), 0.2, kColour);
}

/// By the known radius, or else by that of the last match. Where neither is known, by the area: other things of the
/// colour come in all sizes, the more the smaller.
double size(const ComparedPair& pair, double radius_px, const TargetHistory& history, const MatchOptions& options) {
  if (options.radius_m > 0) {
    const double share = pair.match.both_by_contour ? kContourSize : (options.max_size_ratio - 1) / kGates;
    const double variance =
        squared(pair.radius_sigma_m) + squared(options.radius_tolerance_m) + squared(share * options.radius_m);
    return -0.5 * squared(pair.radius_m - options.radius_m) / variance;
  }
  if (!(pair.radius_m > 0)) return 0;
  if (history.radius_m > 0)
    return -0.5 * squared(natural_log(pair.radius_m / history.radius_m) / natural_log(options.max_size_ratio));
  return by_area(radius_px);
}

/// Log density of the measured position: the larger of those of a steady motion and of the fastest change of motion.
double history_of(const StereoMatch& match, const TargetHistory& history) {
  double best = 0;
  bool any = false;
  for (const auto& predicted : {history.steady, history.manoeuvring}) {
    if (!predicted) continue;
    const Eigen::Vector3d apart = match.point.p_W - predicted->position;
    Eigen::Matrix3d total = match.point.covariance + predicted->covariance;
    if (match.both_by_contour) total += predicted->bias_covariance;
    const double determinant = total.determinant();
    if (!(determinant > 1e-300)) continue;
    const double density = -0.5 * (apart.dot(total.ldlt().solve(apart)) + natural_log(determinant));
    best = any ? std::max(best, density) : density;
    any = true;
  }
  return best;
}

/// Whether a blob is much less compact than the target was.
bool is_ragged(const ComparedPair& pair, const Appearance& left, const Appearance& right,
               const TargetAppearance& target) {
  return !pair.match.both_by_contour && std::min(left.compactness, right.compactness) < kRagged * target.compactness;
}

/// Why a candidate is not chosen: the term by which it falls behind most.
const char* weakness(const Evidence& evidence, const Evidence& best) {
  static constexpr std::array kWhy{"it stands where the colour was before",
                                   "it is less round",
                                   "its colour fits less",
                                   "its two images fit each other less",
                                   "its size fits the target less",
                                   "it is farther from where the target is expected"};
  size_t most = 0;
  for (size_t k = 1; k < kWhy.size(); ++k) {
    if (best.term[k] - evidence.term[k] > best.term[most] - evidence.term[most]) most = k;
  }
  return kWhy[most];
}

}  // namespace

double Evidence::sum() const {
  return std::accumulate(term.begin(), term.end(), 0.0);
}

std::vector<Candidate> candidates_of(std::span<const ComparedPair> pairs, std::span<const Appearance> left,
                                     std::span<const Appearance> right, const TargetHistory& history,
                                     const MatchOptions& options) {
  std::vector<Candidate> candidates;
  for (const ComparedPair& pair : pairs) {
    if (pair.match.status != Status::kSeen) continue;
    Candidate& candidate = candidates.emplace_back();
    candidate.match = pair.match;
    candidate.mixed = pair.mixed;
    candidate.radius_px = pair.radius_px;
    const double radius_m = options.radius_m > 0 ? options.radius_m : history.radius_m;
    if (pair.radius_m > 0) candidate.expected_px = pair.radius_px * radius_m / pair.radius_m;
    const Appearance& in_left = left[static_cast<size_t>(pair.match.left)];
    const Appearance& in_right = right[static_cast<size_t>(pair.match.right)];
    auto& term = candidate.evidence.term;
    term[Evidence::kStill] = interpolated(std::min(in_left.background, in_right.background), 0.3, kStill);
    term[Evidence::kRound] = roundness(pair.match, in_left, in_right);
    term[Evidence::kColour] = colour(in_left, in_right);
    term[Evidence::kStereo] = fit_of(pair, options);
    term[Evidence::kSize] = size(pair, pair.radius_px, history, options);
    term[Evidence::kHistory] = history_of(pair.match, history);
  }
  // Equal sums keep the order of the pairs.
  std::ranges::stable_sort(candidates, [](const Candidate& a, const Candidate& b) {
    return a.mixed != b.mixed ? b.mixed : a.evidence.sum() > b.evidence.sum();
  });
  return candidates;
}

// Discs that do not cover each other are at least the sum of their radii apart, and where one covers a part of the
// other, what remains is at least a radius apart.
bool same_thing(const Candidate& a, const Candidate& b) {
  const double nearest = std::max({a.radius_px + b.radius_px, a.expected_px, b.expected_px});
  return (a.match.left_px - b.match.left_px).norm() < nearest && (a.match.right_px - b.match.right_px).norm() < nearest;
}

bool are_apart(const StereoMatch& a, const StereoMatch& b) {
  return a.left != b.left && a.right != b.right;
}

std::optional<size_t> choose(std::span<Candidate> candidates, size_t sought, double lead) {
  if (candidates.empty() || candidates.front().mixed) return std::nullopt;
  const Evidence& best = candidates.front().evidence;
  std::vector<const Candidate*> things{&candidates.front()};  // that could be a target that is looked for
  for (Candidate& other : candidates.subspan(1)) {
    const bool near = best.sum() - other.evidence.sum() < lead, part = same_thing(candidates.front(), other);
    const bool rival = !other.mixed && near && !part;
    if (rival && std::ranges::none_of(things, [&](const Candidate* thing) { return same_thing(*thing, other); }))
      things.push_back(&other);
    other.reason = other.mixed ? "its two images seem to show two things that look alike"
                   : rival     ? "it could be the target as well"
                   : part      ? "it may be a part of the best one"
                               : weakness(other.evidence, best);
  }
  const bool enough = things.size() <= sought;
  candidates.front().chosen = enough;
  candidates.front().reason = enough ? "chosen" : "others could be the target as well";
  return enough ? std::optional<size_t>(0) : std::nullopt;
}

Eigen::Matrix3d covariance_of_parts(std::span<const Candidate> candidates, size_t number) {
  const Candidate& part = candidates[number];
  Eigen::Vector3d farthest = Eigen::Vector3d::Zero();  // from this part to the centre of both
  for (const Candidate& other : candidates) {
    if (other.mixed || !are_apart(other.match, part.match) || !same_thing(part, other)) continue;
    const double share = squared(other.radius_px) / (squared(other.radius_px) + squared(part.radius_px));
    const Eigen::Vector3d to_both = share * (other.match.point.p_W - part.match.point.p_W);
    if (to_both.squaredNorm() > farthest.squaredNorm()) farthest = to_both;
  }
  return farthest * farthest.transpose();
}

const ComparedPair* outdone_by(const Candidate& candidate, std::span<const Candidate> candidates,
                               std::span<const ComparedPair> pairs,
                               const std::array<std::span<const SphereContour>, 2>& contours,
                               const std::array<std::span<const Appearance>, 2>& appearance, double seen_radius_m,
                               const MatchOptions& options) {
  const auto evidence = [&](size_t side, int k) {
    return appearance_evidence(contours[side][static_cast<size_t>(k)], appearance[side][static_cast<size_t>(k)],
                               options);
  };
  const double least_left = evidence(0, candidate.match.left) + kLead,
               least_right = evidence(1, candidate.match.right) + kLead;
  const auto is_better = [&](const StereoMatch& match) {
    return evidence(0, match.left) > least_left && evidence(1, match.right) > least_right &&
           std::ranges::none_of(candidates, [&](const Candidate& other) {
             return other.match.left == match.left || other.match.right == match.right;
           });
  };
  // A candidate this strong is no speck.
  const bool is_strong = may_start_at_border(candidate.match, candidate.radius_px,
                                             appearance[0][static_cast<size_t>(candidate.match.left)],
                                             appearance[1][static_cast<size_t>(candidate.match.right)]);
  const auto better = std::ranges::find_if(pairs, [&](const ComparedPair& pair) {
    if (pair.match.status == Status::kCutOff) {
      const bool larger = seen_radius_m > 0 && pair.radius_m > options.max_size_ratio * seen_radius_m;
      return !is_strong && !larger && is_better(pair.match);
    }
    const bool apart = pair.match.status == Status::kInconsistentPair || pair.match.status == Status::kEpipolarMismatch;
    if (!apart) return false;
    const SphereContour& in_left = contours[0][static_cast<size_t>(pair.match.left)];
    const SphereContour& in_right = contours[1][static_cast<size_t>(pair.match.right)];
    return pair.size_sigmas < kGates && std::abs(pair.match.epipolar_px) < in_left.radius_px + in_right.radius_px &&
           !in_left.cut_off && !in_right.cut_off && is_better(pair.match);
  });
  return better == pairs.end() ? nullptr : &*better;
}

bool outdoes(const StereoMatch& best, std::span<const Candidate> candidates, const StereoMatch& followed) {
  const auto is_followed = [&](const Candidate& candidate) {
    return candidate.match.left == followed.left && candidate.match.right == followed.right;
  };
  return are_apart(best, followed) && std::ranges::any_of(candidates, is_followed);
}

double evidence_by_looks(const StereoMatch& match, double radius_px, const Appearance& left, const Appearance& right,
                         const MatchOptions& options) {
  return roundness(match, left, right) + colour(left, right) + (options.radius_m > 0 ? 0 : by_area(radius_px));
}

bool is_likely(const StereoMatch& match, double radius_px, const Appearance& left, const Appearance& right) {
  return evidence_by_looks(match, radius_px, left, right, {}) > kLikely;
}

bool is_convincing(const StereoMatch& match, double radius_px, const Appearance& left, const Appearance& right) {
  return evidence_by_looks(match, radius_px, left, right, {}) >= kLikely + kLead;
}

// The second kLead is a choice. On the videos of one camera of docs/real-images.md, with the clicks together, six more
// answers are wrong without it.
bool may_start_at_border(const StereoMatch& match, double radius_px, const Appearance& left, const Appearance& right) {
  return evidence_by_looks(match, radius_px, left, right, {}) >= kLikely + 2 * kLead;
}

bool is_unlike(const ComparedPair& pair, const Appearance& left, const Appearance& right,
               const TargetAppearance& target) {
  const bool smaller = pair.radius_m > 0 && pair.radius_m < kSmaller * target.radius_m;
  return (smaller || is_ragged(pair, left, right, target)) && !is_convincing(pair.match, pair.radius_px, left, right);
}

bool is_smear(const ComparedPair& pair, const Appearance& left, const Appearance& right,
              const TargetAppearance& target) {
  return target.radius_m > 0 && kSmaller * pair.radius_m > target.radius_m && is_ragged(pair, left, right, target);
}

// On the tuning videos and 19 with things pasted into photographs, 9 of 24289 matches of targets fail this check, and
// 30 of 370 matches of other things.
bool is_off_colour(const ComparedPair& pair, const Appearance& left, const Appearance& right) {
  return !pair.match.both_by_contour && std::min(left.colour_share, right.colour_share) == 0 &&
         std::min(left.compactness, right.compactness) < kNoShape;
}

bool fits_known_radius(const Candidate& candidate) {
  const auto& term = candidate.evidence.term;
  return term[Evidence::kStereo] + term[Evidence::kSize] > kLeastFit;
}

}  // namespace multireach::vision
