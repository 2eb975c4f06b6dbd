// Divides what a pair shows among targets that look alike.
#include <algorithm>
#include <utility>

#include "vision/stereo_vision.hpp"
#include "vision/track/equal_targets.hpp"

namespace multireach::vision {
namespace {

using Status = StereoMatch::Status;
using Target = StereoVision::Target;

constexpr size_t kMostClaims = 6;  // of one target

/// Whether two targets have found the same blob. Their windows and white balances may differ a little.
bool same_blob(const Blob& a, const Blob& b) {
  return 2 * static_cast<double>(common_pixels(a, b)) > std::min(a.area, b.area);
}

/// Numbers the blobs of one image that several targets have found, equal ones alike.
class BlobNumbers {
 public:
  int of(const Blob& blob) {
    const auto same = std::ranges::find_if(blobs_, [&](const Blob* other) { return same_blob(*other, blob); });
    if (same != blobs_.end()) return static_cast<int>(same - blobs_.begin());
    blobs_.push_back(&blob);
    return static_cast<int>(blobs_.size()) - 1;
  }

 private:
  std::vector<const Blob*> blobs_;
};

std::vector<Claim> claims_of(const Target& target, std::array<BlobNumbers, 2>& numbers) {
  std::vector<Claim> claims;
  const std::span<const Candidate> candidates = target.candidates;
  for (const Candidate& candidate : candidates.first(std::min(kMostClaims, candidates.size()))) {
    if (candidate.mixed) break;  // the last ones
    const auto before = candidates.first(claims.size());
    const auto part = std::ranges::find_if(before, [&](const Candidate& each) { return same_thing(each, candidate); });
    claims.push_back({.left = numbers[0].of(target.views[0].blobs[static_cast<size_t>(candidate.match.left)]),
                      .right = numbers[1].of(target.views[1].blobs[static_cast<size_t>(candidate.match.right)]),
                      .thing = static_cast<int>(part - before.begin()),
                      .evidence = candidate.evidence.sum()});
  }
  return claims;
}

/// Gives a target the candidate that is its share.
void give(const Share& share, Target& target) {
  for (size_t k = 0; k < target.candidates.size(); ++k) {
    Candidate& candidate = target.candidates[k];
    candidate.chosen = k == share.claim && !share.ambiguous;
    if (candidate.chosen) {
      candidate.reason = "chosen";
    } else if (k == share.claim) {
      candidate.reason = "others could be the target as well";
    } else if (k < share.claim && !candidate.mixed) {
      candidate.reason = "it is another target";
    }
  }
  target.match = target.candidates[*share.claim].match;
  if (share.ambiguous) target.match.status = Status::kAmbiguous;
}

/// Whether a target that is expected elsewhere can have got to its match, as by a bounce.
bool may_be_jump(const Target& target, const PairTimes& times) {
  return target.tracker.is_expected(times) &&
         target.tracker.track().is_near(times.pair, {target.match.point.p_W, target.match.point.covariance});
}

/// What a target may have in a pair, so that no other one has it: its match, or of one that is tracked and ambiguous,
/// all its candidates.
std::vector<const StereoMatch*> things_of(const Target& target, const PairTimes& times) {
  const StereoMatch& match = target.match;
  if (match.left < 0 || match.right < 0) return {};
  const bool expected = target.tracker.is_expected(times);
  switch (match.status) {
    case Status::kSeen:
    case Status::kTogether:
      return {&match};
    case Status::kOutsidePredictionGate:
      return may_be_jump(target, times) ? std::vector{&match} : std::vector<const StereoMatch*>{};
    case Status::kOccludedTooMuch:
    case Status::kCutOff:
      return expected ? std::vector{&match} : std::vector<const StereoMatch*>{};
    case Status::kAmbiguous: {
      std::vector<const StereoMatch*> things;
      if (!expected) return things;
      for (const Candidate& candidate : target.candidates) things.push_back(&candidate.match);
      return things;
    }
    default:
      return {};
  }
}

/// Whether a match is a blob, no contour, and another target is expected within it: the blob may be both.
bool may_be_both(const StereoMatch& match, const Target& owner, const Target& other, const PairTimes& times) {
  const auto expected = other.tracker.expected_px(times);
  if (match.both_by_contour || !expected) return false;
  const auto inside = [&](Side side, int at) {
    const SphereContour& contour = owner.views[index(side)].contours[static_cast<size_t>(at)];
    return ((*expected)[index(side)] - contour.centre_px).norm() < contour.radius_px;
  };
  return inside(Side::kLeft, match.left) && inside(Side::kRight, match.right);
}

}  // namespace

/// What the other targets of a group have of the blobs in `views`. A target that is not expected anywhere takes
/// nothing that touches another one either: it may be a part of it.
OtherTargets StereoVision::others_of(size_t target, const std::vector<size_t>& group, const PairTimes& times,
                                     const std::array<View, 2>& views) const {
  OtherTargets others;
  const bool expected = targets_[target].tracker.is_expected(times);
  for (const Side side : {Side::kLeft, Side::kRight}) others.taken[index(side)].resize(views[index(side)].blobs.size());
  for (const size_t other : group) {
    if (other == target) continue;
    for (const StereoMatch* thing : things_of(targets_[other], times)) {
      for (const Side side : {Side::kLeft, Side::kRight}) {
        const View &own = views[index(side)], &its = targets_[other].views[index(side)];
        const auto at = static_cast<size_t>(side == Side::kLeft ? thing->left : thing->right);
        for (size_t k = 0; k < own.blobs.size(); ++k) {
          const double apart = (own.contours[k].centre_px - its.contours[at].centre_px).norm();
          const bool touches = apart < own.contours[k].radius_px + its.contours[at].radius_px;
          if ((!expected && touches) || same_blob(own.blobs[k], its.blobs[at])) others.taken[index(side)][k] = true;
        }
      }
    }
  }
  return others;
}

/// Divides what the pair shows among targets that look alike: those that are expected somewhere by their motion, the
/// others in their order.
void StereoVision::divide_things(const std::vector<size_t>& group, const PairTimes& times) {
  std::array<BlobNumbers, 2> numbers;
  std::vector<size_t> expected, without, ambiguous, lost;
  std::vector<std::vector<Claim>> claims;
  for (const size_t k : group) {
    Target& target = targets_[k];
    const bool seen = target.match.status == Status::kSeen || target.match.status == Status::kAmbiguous;
    if (!target.tracker.is_expected(times)) {
      lost.push_back(k);
      target.match = {};
    } else if (seen) {
      expected.push_back(k);
      claims.push_back(claims_of(target, numbers));
    } else {
      without.push_back(k);
      target.match = {};
    }
  }
  const std::vector<Share> shares = divide(claims);
  for (size_t k = 0; k < expected.size(); ++k) {
    Target& target = targets_[expected[k]];
    if (shares[k].claim) {
      give(shares[k], target);
    } else {
      target.match = {};
      without.push_back(expected[k]);
      if (shares[k].ambiguous) ambiguous.push_back(expected[k]);
    }
  }
  const auto match_again = [&](size_t k, size_t sought) {
    Target& target = targets_[k];
    OtherTargets others = others_of(k, group, times, target.views);
    others.sought = sought;
    StereoTracker::Found found = target.tracker.match(times, target.views[0], target.views[1], others);
    target.match = found.match;
    target.candidates = std::move(found.candidates);
  };
  for (const size_t k : without) {
    for (const size_t owner : expected) {
      StereoMatch& match = targets_[owner].match;
      if (owner == k || match.left < 0 || match.status != Status::kSeen) continue;
      if (!may_be_both(match, targets_[owner], targets_[k], times)) continue;
      match.status = Status::kTogether;
      for (Candidate& candidate : targets_[owner].candidates) {
        if (std::exchange(candidate.chosen, false)) candidate.reason = description(Status::kTogether);
      }
    }
    match_again(k, 1);
  }
  for (const size_t k : ambiguous) targets_[k].match.status = Status::kAmbiguous;
  for (auto next = lost.begin(); next != lost.end(); ++next) {
    // How many are looked for where this one is.
    const auto same_place = [&](size_t other) {
      const auto &its = targets_[other].tracker.options().search_region,
                 &own = targets_[*next].tracker.options().search_region;
      return its && own ? its->min() == own->min() && its->max() == own->max() : !its && !own;
    };
    match_again(*next, static_cast<size_t>(std::count_if(next, lost.end(), same_place)));
  }
  // What is too far away to be a jump is left to a target that is lost, now or when it can be measured.
  for (const size_t k : without) {
    StereoMatch& match = targets_[k].match;
    if (lost.empty() || match.status != Status::kOutsidePredictionGate || may_be_jump(targets_[k], times)) continue;
    match = {};
    match.status = Status::kOtherTarget;
  }
  for (const size_t k : group) {
    Target& target = targets_[k];
    target.found_inside_windows = target.tracker.is_inside_windows(target.match, target.views[0], target.views[1]);
  }
}

}  // namespace multireach::vision
