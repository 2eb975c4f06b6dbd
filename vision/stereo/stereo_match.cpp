#include "vision/stereo/stereo_match.hpp"

#include <algorithm>
#include <cmath>

#include "vision/stereo/compare_contours.hpp"

namespace multireach::vision {
namespace {

using Status = StereoMatch::Status;

constexpr double kWrongRig = 0.02;  // share of the image's width that a wrong calibration is off at most: a choice

constexpr int kMismatched = 2;  // rank of a pair of contours that violate the epipolar constraint

/// Rank of a compared pair: the higher, the more checks it passed. The pair of highest rank is chosen. A partly
/// visible thing away from the prediction says nothing about the target.
int progress(const ComparedPair& pair) {
  switch (pair.match.status) {
    case Status::kSeen:
      return 6;
    case Status::kOccludedTooMuch:
    case Status::kCutOff:
      return pair.outside_gate ? 3 : 5;
    case Status::kOutsidePredictionGate:
      return 4;
    case Status::kWrongRadius:
    case Status::kUnlike:
    case Status::kOffColour:
    case Status::kOutsideRegion:
      return 3;
    case Status::kEpipolarMismatch:
      return kMismatched;
    case Status::kInconsistentPair:
      return 1;
    default:
      return 0;
  }
}

/// Of two objects that look alike, each left contour fits both right ones, or one does. The pairs that exchange their
/// order are most likely wrong, unless they fit clearly better than the others: marks the wrong ones.
void mark_mixed(std::span<const SphereContour> left, std::span<const SphereContour> right, const MatchOptions& options,
                std::vector<ComparedPair>& all) {
  const auto pair = [&](size_t i, size_t j) -> ComparedPair& { return all[i * right.size() + j]; };
  const auto seen = [&](size_t i, size_t j) {
    return pair(i, j).match.status == Status::kSeen || pair(i, j).cut_off_blob;
  };
  const auto fit_of_both = [&](size_t i, size_t j, size_t other_i, size_t other_j) {
    return fit_of(pair(i, j), options) + fit_of(pair(other_i, other_j), options);
  };
  for (size_t i = 0; i < left.size(); ++i) {
    for (size_t other_i = i + 1; other_i < left.size(); ++other_i) {
      for (size_t j = 0; j < right.size(); ++j) {
        for (size_t other_j = 0; other_j < right.size(); ++other_j) {
          const double in_left = left[other_i].ray().x() - left[i].ray().x();
          const double in_right = right[other_j].ray().x() - right[j].ray().x();
          if (!(in_left * in_right < 0)) continue;
          // (i, j) and (other_i, other_j) exchange the order, (i, other_j) and (other_i, j) keep it.
          if (!seen(i, other_j) || !seen(other_i, j)) continue;
          if (seen(i, j) != seen(other_i, other_j)) {
            ComparedPair& crossed = seen(i, j) ? pair(i, j) : pair(other_i, other_j);
            if (fit_of(crossed, options) < 0.5 * fit_of_both(i, other_j, other_i, j) + kLead) crossed.mixed = true;
            continue;
          }
          if (!seen(i, j)) continue;
          if (fit_of_both(i, j, other_i, other_j) > fit_of_both(i, other_j, other_i, j) + kLead) {
            pair(i, other_j).mixed = pair(other_i, j).mixed = true;
          } else {
            pair(i, j).mixed = pair(other_i, other_j).mixed = true;
          }
        }
      }
    }
  }
}

const SphereContour& largest(std::span<const SphereContour> contours) {
  return *std::ranges::max_element(contours, {}, &SphereContour::area);
}

}  // namespace

bool has_position(StereoMatch::Status status) {
  return status == Status::kSeen || status == Status::kOccludedTooMuch || status == Status::kCutOff ||
         status == Status::kWrongRadius || status == Status::kOutsidePredictionGate;
}

const char* description(StereoMatch::Status status) {
  switch (status) {
    case Status::kSeen:
      return "seen";
    case Status::kWrongImageSize:
      return "the size of an image differs from the calibration";
    case Status::kLeftDark:
      return "the left image is black";
    case Status::kRightDark:
      return "the right image is black";
    case Status::kColourEverywhere:
      return "the colour fills most of an image: the colour model is too wide";
    case Status::kNotInLeft:
      return "not seen in the left image";
    case Status::kNotInRight:
      return "not seen in the right image";
    case Status::kCutOff:
      return "the target is cut off by the image border";
    case Status::kMoreAtBorder:
      return "something at the image border is more like the target than what is wholly seen";
    case Status::kInconsistentPair:
      return "the two images show different objects";
    case Status::kEpipolarMismatch:
      return "the contours agree in size, but violate the epipolar constraint";
    case Status::kBehindCameras:
      return "the two viewing rays do not meet in front of the cameras";
    case Status::kNoDistance:
      return "its distance does not exceed its standard deviation";
    case Status::kImagesSwapped:
      return "the left and the right image seem to be swapped";
    case Status::kOccludedTooMuch:
      return "too much of the target is occluded";
    case Status::kWrongRadius:
      return "size and distance disagree: check ball_radius_m, or calibrate again";
    case Status::kOutsidePredictionGate:
      return "something is seen, but not where the object can be by now";
    case Status::kOutsideRegion:
      return "objects of the target's colour are seen only outside search_region_m";
    case Status::kOnlyBackground:
      return "only things that stood there before have this colour";
    case Status::kUnlike:
      return "only things of another size, or much more ragged, than the target are seen";
    case Status::kUnlikely:
      return "only small or ragged blobs of the target's colour are seen";
    case Status::kOffColour:
      return "only things whose colours are at the limits of the target's are seen";
    case Status::kSeveralElsewhere:
      return "several things are seen, but none where the object can be by now";
    case Status::kAmbiguous:
      return "several things could be the target";
    case Status::kOtherTarget:
      return "only another target that looks the same is seen";
    case Status::kTogether:
      return "this target and another one that looks the same are seen as one";
  }
  return "";
}

const char* description_of_seen(const StereoMatch& match, const MatchOptions& options) {
  if (match.point.epipolar_error_px <= options.max_epipolar_px) return description(Status::kSeen);
  return "seen, but its two images are off one epipolar line";
}

std::vector<ComparedPair> compare_pairs(const StereoRig& rig, std::span<const SphereContour> left,
                                        std::span<const SphereContour> right,
                                        const std::optional<Prediction>& prediction, const MatchOptions& options) {
  std::vector<ComparedPair> all;
  for (size_t i = 0; i < left.size(); ++i) {
    for (size_t j = 0; j < right.size(); ++j) {
      all.push_back(compare_contours(rig, left[i], right[j], prediction, options));
      all.back().match.left = static_cast<int>(i);
      all.back().match.right = static_cast<int>(j);
    }
  }
  if (prediction) return all;
  mark_mixed(left, right, options, all);
  constexpr double kMixed = 1e-6;  // lowers the scores below those of the others
  for (ComparedPair& pair : all) {
    if (pair.mixed) pair.score *= kMixed;
  }
  return all;
}

const ComparedPair* contradiction_of(std::span<const ComparedPair> pairs, const StereoRig& rig, size_t located) {
  const auto is_located = [](const ComparedPair& pair) { return progress(pair) > kMismatched; };
  const auto share_one = [](const ComparedPair& a, const ComparedPair& b) {
    return a.match.left == b.match.left || a.match.right == b.match.right;
  };
  // Pairs that have no contour in common, taken in their order.
  std::vector<const ComparedPair*> fitting, mismatched;
  const auto add = [&](const ComparedPair& pair, std::vector<const ComparedPair*>& chosen) {
    if (std::ranges::none_of(chosen, [&](const ComparedPair* other) { return share_one(pair, *other); }))
      chosen.push_back(&pair);
  };
  for (const ComparedPair& pair : pairs) {
    if (is_located(pair)) add(pair, fitting);
  }
  for (const ComparedPair& pair : pairs) {
    const bool near = std::abs(pair.match.epipolar_px) < kWrongRig * rig.left.width;
    if (pair.match.status != Status::kEpipolarMismatch || !near) continue;
    if (std::ranges::none_of(pairs,
                             [&](const ComparedPair& other) { return is_located(other) && share_one(pair, other); }))
      add(pair, mismatched);
  }
  return mismatched.size() > fitting.size() + located ? mismatched.front() : nullptr;
}

StereoMatch best_match(std::span<const SphereContour> left, std::span<const SphereContour> right,
                       std::span<const ComparedPair> pairs) {
  StereoMatch none;
  if (!left.empty()) none.left_px = largest(left).centre_px;
  if (!right.empty()) none.right_px = largest(right).centre_px;
  none.status = left.empty() ? Status::kNotInLeft : Status::kNotInRight;
  if (left.empty() || right.empty() || pairs.empty()) return none;
  const ComparedPair* best = nullptr;
  for (const ComparedPair& scored : pairs) {
    const int came = progress(scored), best_came = best ? progress(*best) : -1;
    if (came > best_came || (came == best_came && scored.score > best->score)) best = &scored;
  }
  return best->match;
}

StereoMatch match_candidates(const StereoRig& rig, std::span<const SphereContour> left,
                             std::span<const SphereContour> right, const std::optional<Prediction>& prediction,
                             const MatchOptions& options) {
  return best_match(left, right, compare_pairs(rig, left, right, prediction, options));
}

}  // namespace multireach::vision
