#include "vision/association/group_assignment.hpp"

#include <algorithm>
#include <utility>

#include "vision/association/solid_targets.hpp"
#include "vision/track/object_prediction.hpp"

namespace multireach::vision {
namespace {

using Status = StereoMatch::Status;
using Target = StereoVision::Target;

constexpr size_t kMostHypotheses = 6;  // of one target

/// Whether two targets have found the same blob. Their windows and white balances may differ a little.
bool same_blob(const Blob& a, const Blob& b) {
  return 2 * static_cast<double>(common_pixels(a, b)) > std::min(a.area, b.area);
}

const Blob& blob_of(const Target& target, const StereoMatch& match, Side side) {
  const int at = side == Side::kLeft ? match.left : match.right;
  return target.views[index(side)].blobs[static_cast<size_t>(at)];
}

Hypothesis hypothesis_of(const StereoMatch& match, const Target& target, std::array<BlobNumbers, 2>& numbers) {
  return {.left = numbers[0].of(blob_of(target, match, Side::kLeft)),
          .right = numbers[1].of(blob_of(target, match, Side::kRight))};
}

std::vector<Hypothesis> hypotheses_of(const Target& target, std::array<BlobNumbers, 2>& numbers) {
  std::vector<Hypothesis> hypotheses;
  const std::span<const Candidate> candidates = target.candidates;
  for (const Candidate& candidate : candidates.first(std::min(kMostHypotheses, candidates.size()))) {
    if (candidate.mixed) break;  // the last ones
    const auto before = candidates.first(hypotheses.size());
    const auto part = std::ranges::find_if(before, [&](const Candidate& each) { return same_thing(each, candidate); });
    Hypothesis& hypothesis = hypotheses.emplace_back(hypothesis_of(candidate.match, target, numbers));
    const auto first = static_cast<size_t>(part - before.begin());
    hypothesis.thing = part == before.end() ? static_cast<int>(first) : hypotheses[first].thing;
    hypothesis.evidence = candidate.evidence.sum();
  }
  return hypotheses;
}

PositionEstimate position_of(const StereoMatch& match) {
  return {match.point.p_W, match.noise_covariance(), match.bias_covariance()};
}

bool same_region(const Target& a, const Target& b) {
  const auto &first = a.tracker.options().search_region, &second = b.tracker.options().search_region;
  return first && second ? first->min() == second->min() && first->max() == second->max() : !first && !second;
}

/// Gives a target the candidate that is assigned to it.
void give(const Assignment& assignment, Target& target) {
  for (size_t k = 0; k < target.candidates.size(); ++k) {
    Candidate& candidate = target.candidates[k];
    candidate.chosen = k == assignment.hypothesis && !assignment.ambiguous;
    if (candidate.chosen) {
      candidate.reason = "chosen";
    } else if (k == assignment.hypothesis) {
      candidate.reason = "others could be the target as well";
    } else if (k < assignment.hypothesis && !candidate.mixed) {
      candidate.reason = "it is another target";
    }
  }
  target.match = target.candidates[*assignment.hypothesis].match;
  if (assignment.ambiguous) target.match.status = Status::kAmbiguous;
}

/// Whether the track goes on, and tells where the target is in this pair.
bool is_expected(const Target& target, const PairTimes& times) {
  return !target.begins_anew && history_at(target.tracker.options(), target.tracker.object(), times).manoeuvring;
}

/// Whether a target that is expected elsewhere can have got to its match, as by a bounce. That shows at once: what
/// appears after some time is more likely a target that is lost.
bool may_be_jump(const Target& target, const PairTimes& times) {
  const PositionEstimate there = position_of(target.match);
  return is_expected(target, times) && target.tracker.track().was_just_seen(times.pair) &&
         target.tracker.track().is_near(times.pair, there);
}

/// What a target may have in a pair, so that no other one has it: its match, or of one that is tracked and ambiguous,
/// all its candidates.
std::vector<const StereoMatch*> things_of(const Target& target, const PairTimes& times) {
  const StereoMatch& match = target.match;
  if (match.left < 0 || match.right < 0) return {};
  const bool expected = is_expected(target, times);
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

/// Whether it is arbitrary so far which of the things that look alike the target follows.
bool is_tentative(const Target& target) {
  return !target.tracker.identity().established();
}

/// Whether two targets are seen outside of their predictions, as the same blob in one of the images.
bool jumped_to_same(const Target& a, const Target& b) {
  if (a.match.status != Status::kOutsidePredictionGate || b.match.status != Status::kOutsidePredictionGate)
    return false;
  return std::ranges::any_of(std::array{Side::kLeft, Side::kRight}, [&](Side side) {
    return same_blob(blob_of(a, a.match, side), blob_of(b, b.match, side));
  });
}

/// Distance of a match from where the target was seen last, m.
double distance_jumped(const Target& target) {
  const TargetTrack& track = target.tracker.track();
  return (target.match.point.p_W - track.position_at(*track.last_seen_utime())).norm();
}

/// Of the targets `among` that may have jumped to the same thing, it is the one that was nearest.
void keep_nearest_jumps(const std::vector<size_t>& among, std::vector<Target>& targets) {
  std::vector<size_t> farther;
  for (const size_t k : among) {
    const bool other_is_nearer = std::ranges::any_of(among, [&](size_t other) {
      return other != k && jumped_to_same(targets[k], targets[other]) &&
             std::pair(distance_jumped(targets[other]), other) < std::pair(distance_jumped(targets[k]), k);
    });
    if (other_is_nearer) farther.push_back(k);
  }
  for (const size_t k : farther) {
    targets[k].match = {};
    targets[k].match.status = Status::kOtherTarget;
  }
}

/// Whether the blob of a match is so long, in both images, that it may be two things: a disc has a compactness of 1,
/// two that touch have 0.4.
bool may_be_two(const Target& target) {
  constexpr double kRound = 0.6;
  const StereoMatch& match = target.match;
  return target.views[0].appearance[static_cast<size_t>(match.left)].compactness < kRound &&
         target.views[1].appearance[static_cast<size_t>(match.right)].compactness < kRound;
}

/// Whether the match of `owner` may be another target as well: a blob, no contour, within which that one is expected;
/// or, of tentative targets, what may be either, and two.
bool may_be_both(const Target& owner, const Target& other, const PairTimes& times) {
  const StereoMatch& match = owner.match;
  const auto at_both = [&](auto&& test) {
    return test(Side::kLeft, static_cast<size_t>(match.left)) && test(Side::kRight, static_cast<size_t>(match.right));
  };
  const auto is_candidate_of_other = [&](Side side, size_t at) {
    return std::ranges::any_of(other.candidates, [&](const Candidate& each) {
      return same_blob(blob_of(other, each.match, side), owner.views[index(side)].blobs[at]);
    });
  };
  if (is_tentative(owner) && is_tentative(other) && may_be_two(owner) && at_both(is_candidate_of_other)) return true;
  const auto expected = predicted_px(other.tracker.options(), other.tracker.object(), times);
  if (match.both_by_contour || !expected) return false;
  return at_both([&](Side side, size_t at) {
    const SphereContour& contour = owner.views[index(side)].contours[at];
    return ((*expected)[index(side)] - contour.centre_px).norm() < contour.radius_px;
  });
}

}  // namespace

int BlobNumbers::of(const Blob& blob) {
  const auto same = std::ranges::find_if(blobs_, [&](const Blob* other) { return same_blob(*other, blob); });
  if (same != blobs_.end()) return static_cast<int>(same - blobs_.begin());
  blobs_.push_back(&blob);
  return static_cast<int>(blobs_.size()) - 1;
}

OtherTargets others_of(size_t target, const std::vector<size_t>& group, const std::vector<Target>& targets,
                       const PairTimes& times, const std::array<View, 2>& views) {
  OtherTargets others;
  const bool expected = is_expected(targets[target], times);
  for (const Side side : {Side::kLeft, Side::kRight}) others.taken[index(side)].resize(views[index(side)].blobs.size());
  for (const size_t other : group) {
    if (other == target) continue;
    for (const StereoMatch* thing : things_of(targets[other], times)) {
      for (const Side side : {Side::kLeft, Side::kRight}) {
        const View &own = views[index(side)], &its = targets[other].views[index(side)];
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

void GroupAssignment::run() {
  for (const size_t k : group_) targets_[k].begins_anew = false;
  match_bounces();
  sort_targets();
  assign_expected();
  match_unassigned();
  match_lost();
  replace_doubtful();
  leave_far_jumps();
  for (const size_t k : group_) {
    Target& target = targets_[k];
    target.found_inside_windows =
        target.tracker.is_inside_windows(times_, target.match, target.views[0], target.views[1]);
  }
}

bool GroupAssignment::is_expected(size_t target) const {
  return vision::is_expected(targets_[target], times_);
}

/// Matches targets that cannot keep their motion with all that they can have got to.
void GroupAssignment::match_bounces() {
  for (const size_t k : group_) {
    Target& target = targets_[k];
    const auto in_the_way = [&](size_t other) {
      return other != k && is_expected(other) && would_bounce(target, targets_[other], times_.pair);
    };
    if (!is_expected(k) || std::ranges::none_of(group_, in_the_way)) continue;
    TargetMatch found = target.tracker.match(times_, target.views[0], target.views[1],
                                             {.taken = {}, .unknown = true, .anywhere = true});
    std::erase_if(found.candidates, [&](const Candidate& each) {
      return !target.tracker.track().is_near(times_.pair, position_of(each.match));
    });
    if (found.candidates.empty()) continue;
    target.candidates = std::move(found.candidates);
    target.match = target.candidates.front().match;
  }
}

/// Tells which targets are expected and may be seen there, which are expected only, and which may be anywhere.
void GroupAssignment::sort_targets() {
  for (const size_t k : group_) {
    Target& target = targets_[k];
    if (!is_expected(k)) {
      lost_.push_back(k);
      target.match = {};
    } else if (target.match.status == Status::kSeen || target.match.status == Status::kAmbiguous) {
      expected_.push_back(k);
      hypotheses_.push_back(hypotheses_of(target, numbers_));
    } else {
      const bool jumps = target.match.status == Status::kOutsidePredictionGate && may_be_jump(target, times_);
      if (jumps && !is_tentative(target)) jumps_.push_back(hypothesis_of(target.match, target, numbers_));
      // Whatever a tentative target is that seems to jump, it takes what is left, as one that is not seen yet.
      target.begins_anew = jumps && is_tentative(target) && !may_be_two(target);
      (target.begins_anew ? lost_ : unassigned_).push_back(k);
      target.match = {};
    }
  }
}

/// Gives the expected targets what they are by the likeliest association.
void GroupAssignment::assign_expected() {
  const bool one_region =
      std::ranges::all_of(group_, [&](size_t k) { return same_region(targets_[group_[0]], targets_[k]); });
  std::vector<bool> tentative;
  for (const size_t k : expected_) tentative.push_back(one_region && is_tentative(targets_[k]));
  add_jump_hypotheses(tentative);
  const auto excluded = [&](auto a, auto b) {
    if (a.first >= expected_.size() || b.first >= expected_.size()) return false;
    const Target &target_a = targets_[expected_[a.first]], &target_b = targets_[expected_[b.first]];
    return pass_through(target_a, target_a.candidates[a.second].match, target_b, target_b.candidates[b.second].match);
  };
  const std::vector<Assignment> assignments = assign(hypotheses_, excluded, tentative, lost_.size());
  for (size_t k = 0; k < expected_.size(); ++k) {
    Target& target = targets_[expected_[k]];
    if (assignments[k].hypothesis) {
      give(assignments[k], target);
      continue;
    }
    target.match = {};
    unassigned_.push_back(expected_[k]);
    if (assignments[k].ambiguous) ambiguous_.push_back(expected_[k]);
  }
}

/// A jump has no evidence of its own: it only keeps tentative targets from having two things, one of which is the
/// target that jumped. Another established target goes first. `tentative`: of the expected targets.
void GroupAssignment::add_jump_hypotheses(const std::vector<bool>& tentative) {
  for (const Hypothesis& jump : jumps_) {
    const auto is_it = [&](const Hypothesis& each) { return each.left == jump.left || each.right == jump.right; };
    bool taken = false;
    for (size_t k = 0; k < expected_.size(); ++k)
      taken = taken || (!tentative[k] && std::ranges::any_of(hypotheses_[k], is_it));
    if (!taken) hypotheses_.push_back({jump});
  }
}

/// Matches the targets to which nothing was assigned with what is left.
void GroupAssignment::match_unassigned() {
  for (const size_t k : unassigned_) {
    withhold_shared_blobs(k);
    match_again(k, 1);
  }
  for (const size_t k : ambiguous_) {
    targets_[k].match.status = Status::kAmbiguous;
    for (Candidate& candidate : targets_[k].candidates) {
      if (std::exchange(candidate.chosen, false)) candidate.reason = description(Status::kAmbiguous);
    }
  }
}

/// A blob in which this target is expected, too, is no other one's.
void GroupAssignment::withhold_shared_blobs(size_t target) {
  for (const size_t owner : expected_) {
    StereoMatch& match = targets_[owner].match;
    if (owner == target || match.left < 0 || match.status != Status::kSeen) continue;
    if (!may_be_both(targets_[owner], targets_[target], times_)) continue;
    match.status = Status::kTogether;
    for (Candidate& candidate : targets_[owner].candidates) {
      if (std::exchange(candidate.chosen, false)) candidate.reason = description(Status::kTogether);
    }
  }
}

/// Matches the targets that may be anywhere with what is left, in their order.
void GroupAssignment::match_lost() {
  for (auto next = lost_.begin(); next != lost_.end(); ++next) {
    // How many are looked for where this one is.
    const auto here = [&](size_t other) { return same_region(targets_[other], targets_[*next]); };
    match_again(*next, static_cast<size_t>(std::count_if(next, lost_.end(), here)));
  }
}

void GroupAssignment::match_again(size_t target, size_t sought) {
  Target& its = targets_[target];
  OtherTargets others = others_of(target, group_, targets_, times_, its.views);
  others.sought = sought;
  others.sought_elsewhere = std::max(sought, unassigned_.size() + lost_.size());
  others.anywhere = its.begins_anew;
  TargetMatch found = its.tracker.match(times_, its.views[0], its.views[1], others);
  its.match = found.match;
  its.candidates = std::move(found.candidates);
}

/// Gives targets that are in doubt what replaces what they follow, if no other one has it.
void GroupAssignment::replace_doubtful() {
  std::vector<size_t> replaced;
  for (const size_t k : expected_) {
    Target& target = targets_[k];
    if (target.match.status != Status::kSeen || !target.tracker.identity().doubtful(times_.pair)) continue;
    TargetMatch found = target.tracker.match(times_, target.views[0], target.views[1],
                                             others_of(k, group_, targets_, times_, target.views));
    // Where the match of this target was not among the contours, what was found replaces something else.
    const bool same =
        found.replaces && found.replaces->left == target.match.left && found.replaces->right == target.match.right;
    const auto takes_it = [&](size_t other) {
      return std::ranges::any_of(std::array{Side::kLeft, Side::kRight}, [&](Side side) {
        return same_blob(blob_of(target, found.match, side), blob_of(targets_[other], targets_[other].match, side));
      });
    };
    if (!same || std::ranges::any_of(replaced, takes_it)) continue;
    target.match = found.match;
    target.candidates = std::move(found.candidates);
    replaced.push_back(k);
  }
}

/// Of targets that may have jumped to the same thing, the nearest one has it; and what is too far away to be a jump is
/// left to a target that is lost, now or when it can be measured.
void GroupAssignment::leave_far_jumps() {
  keep_nearest_jumps(unassigned_, targets_);
  for (const size_t k : unassigned_) {
    StereoMatch& match = targets_[k].match;
    if (lost_.empty() || match.status != Status::kOutsidePredictionGate || may_be_jump(targets_[k], times_)) continue;
    match = {};
    match.status = Status::kOtherTarget;
  }
}

}  // namespace multireach::vision
