// Assigns what a pair shows to targets that look alike.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numbers>
#include <utility>

#include "vision/stereo_vision.hpp"
#include "vision/track/equal_targets.hpp"

namespace multireach::vision {
namespace {

using Status = StereoMatch::Status;
using Target = StereoVision::Target;

constexpr size_t kMostHypotheses = 6;  // of one target

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
    hypothesis.thing = static_cast<int>(part - before.begin());
    hypothesis.evidence = candidate.evidence.sum();
  }
  return hypotheses;
}

/// Whether two solid bodies whose relative position changes from `before` to `after` on a straight line would go
/// through each other, also with the errors of `after` (`covariance`, m^2). Bodies that roll over each other by a
/// quarter turn do not: on the chord of that turn they come as near as the root of two of the radius.
bool pass_through(const Eigen::Vector3d& before, const Eigen::Vector3d& after, const Eigen::Matrix3d& covariance,
                  double radius_m) {
  constexpr double kSigmas = 3;
  const Eigen::Vector3d change = after - before;
  const double approach = -before.dot(change);
  if (approach <= 0) return false;
  // The errors along the motion change the time only.
  const double part = std::min(approach / change.squaredNorm(), 1.0);
  const Eigen::Vector3d direction = change.normalized();
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - direction * direction.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> errors(across * covariance * across, Eigen::EigenvaluesOnly);
  const double sigma = part * std::sqrt(std::max(0.0, errors.eigenvalues().maxCoeff()));
  return (before + part * change).norm() + kSigmas * sigma < std::numbers::sqrt2 * radius_m;
}

double smaller_radius(const Target& a, const Target& b) {
  return std::min(a.tracker.radius_m(), b.tracker.radius_m());
}

/// Position of `b` relative to `a` when both were seen last, m, in W.
Eigen::Vector3d relative_when_seen(const TargetTrack& a, const TargetTrack& b) {
  const int64_t seen = std::min(*a.last_seen_utime(), *b.last_seen_utime());
  return b.position_at(seen) - a.position_at(seen);
}

PositionEstimate position_of(const StereoMatch& match) {
  return {match.point.p_W, match.noise_covariance(), match.bias_covariance()};
}

/// m^2, of how far a target has moved to a match: a bias that only the track has looks like motion.
Eigen::Matrix3d covariance_of_change(const Target& target, const StereoMatch& match) {
  Eigen::Matrix3d covariance = match.noise_covariance();
  if (match.both_by_contour) covariance += target.tracker.track().estimate().bias_covariance;
  return covariance;
}

bool pass_through(const Target& a, const StereoMatch& match_a, const Target& b, const StereoMatch& match_b) {
  return pass_through(relative_when_seen(a.tracker.track(), b.tracker.track()), match_b.point.p_W - match_a.point.p_W,
                      covariance_of_change(a, match_a) + covariance_of_change(b, match_b), smaller_radius(a, b));
}

/// Whether two solid targets cannot both keep their motion, because they would go through each other. Their bias does
/// not count: with it, targets that are measured by centroids would never be said to.
bool would_bounce(const Target& a, const Target& b, int64_t utime) {
  const TargetTrack &track_a = a.tracker.track(), &track_b = b.tracker.track();
  const auto at_a = track_a.predicted_steady(utime), at_b = track_b.predicted_steady(utime);
  return at_a && at_b &&
         pass_through(relative_when_seen(track_a, track_b), at_b->position - at_a->position,
                      at_a->covariance + at_b->covariance, smaller_radius(a, b));
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
  return !target.begins_anew && target.tracker.is_expected(times);
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
  const auto expected = other.tracker.expected_px(times);
  if (match.both_by_contour || !expected) return false;
  return at_both([&](Side side, size_t at) {
    const SphereContour& contour = owner.views[index(side)].contours[at];
    return ((*expected)[index(side)] - contour.centre_px).norm() < contour.radius_px;
  });
}

}  // namespace

/// What the other targets of a group have of the blobs in `views`. A target that is not expected anywhere takes
/// nothing that touches another one either: it may be a part of it.
OtherTargets StereoVision::others_of(size_t target, const std::vector<size_t>& group, const PairTimes& times,
                                     const std::array<View, 2>& views) const {
  OtherTargets others;
  const bool expected = is_expected(targets_[target], times);
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

/// Matches targets that cannot keep their motion with all that they can have got to.
void StereoVision::match_bounces(const std::vector<size_t>& group, const PairTimes& times) {
  for (const size_t k : group) {
    Target& target = targets_[k];
    const auto in_the_way = [&](size_t other) {
      return other != k && is_expected(targets_[other], times) && would_bounce(target, targets_[other], times.pair);
    };
    if (!is_expected(target, times) || std::ranges::none_of(group, in_the_way)) continue;
    StereoTracker::Found found =
        target.tracker.match(times, target.views[0], target.views[1], {.taken = {}, .unknown = true, .anywhere = true});
    std::erase_if(found.candidates, [&](const Candidate& each) {
      return !target.tracker.track().is_near(times.pair, position_of(each.match));
    });
    if (found.candidates.empty()) continue;
    target.candidates = std::move(found.candidates);
    target.match = target.candidates.front().match;
  }
}

/// Assigns what the pair shows to targets that look alike: those that are expected somewhere by their motion, the
/// others in their order.
void StereoVision::assign_things(const std::vector<size_t>& group, const PairTimes& times) {
  for (const size_t k : group) targets_[k].begins_anew = false;
  match_bounces(group, times);
  std::array<BlobNumbers, 2> numbers;
  std::vector<size_t> expected, without, ambiguous, lost;
  std::vector<std::vector<Hypothesis>> hypotheses;
  std::vector<Hypothesis> jumps;
  for (const size_t k : group) {
    Target& target = targets_[k];
    const bool seen = target.match.status == Status::kSeen || target.match.status == Status::kAmbiguous;
    if (!is_expected(target, times)) {
      lost.push_back(k);
      target.match = {};
    } else if (seen) {
      expected.push_back(k);
      hypotheses.push_back(hypotheses_of(target, numbers));
    } else {
      const bool outside = target.match.status == Status::kOutsidePredictionGate && may_be_jump(target, times);
      if (outside && is_tentative(target) && !may_be_two(target)) {
        // Whatever it is, it takes what is left, as one that is not seen yet.
        target.begins_anew = true;
        lost.push_back(k);
      } else {
        if (outside && !is_tentative(target)) jumps.push_back(hypothesis_of(target.match, target, numbers));
        without.push_back(k);
      }
      target.match = {};
    }
  }
  const bool one_region =
      std::ranges::all_of(group, [&](size_t k) { return same_region(targets_[group[0]], targets_[k]); });
  std::vector<bool> tentative;
  for (const size_t k : expected) tentative.push_back(one_region && is_tentative(targets_[k]));
  // A jump has no evidence of its own: it only keeps tentative targets from having two things, one of which is the
  // target that jumped. Another established target goes first.
  for (const Hypothesis& jump : jumps) {
    bool taken = false;
    for (size_t k = 0; k < expected.size(); ++k) {
      const auto is_it = [&](const Hypothesis& each) { return each.left == jump.left || each.right == jump.right; };
      taken = taken || (!tentative[k] && std::ranges::any_of(hypotheses[k], is_it));
    }
    if (!taken) hypotheses.push_back({jump});
  }
  const auto excluded = [&](auto a, auto b) {
    if (a.first >= expected.size() || b.first >= expected.size()) return false;
    const Target &target_a = targets_[expected[a.first]], &target_b = targets_[expected[b.first]];
    return pass_through(target_a, target_a.candidates[a.second].match, target_b, target_b.candidates[b.second].match);
  };
  const std::vector<Assignment> assignments = assign(hypotheses, excluded, tentative, lost.size());
  for (size_t k = 0; k < expected.size(); ++k) {
    Target& target = targets_[expected[k]];
    if (assignments[k].hypothesis) {
      give(assignments[k], target);
    } else {
      target.match = {};
      without.push_back(expected[k]);
      if (assignments[k].ambiguous) ambiguous.push_back(expected[k]);
    }
  }
  const auto match_again = [&](size_t k, size_t sought) {
    Target& target = targets_[k];
    OtherTargets others = others_of(k, group, times, target.views);
    others.sought = sought;
    others.sought_elsewhere = std::max(sought, without.size() + lost.size());
    others.anywhere = target.begins_anew;
    StereoTracker::Found found = target.tracker.match(times, target.views[0], target.views[1], others);
    target.match = found.match;
    target.candidates = std::move(found.candidates);
  };
  for (const size_t k : without) {
    for (const size_t owner : expected) {
      StereoMatch& match = targets_[owner].match;
      if (owner == k || match.left < 0 || match.status != Status::kSeen) continue;
      if (!may_be_both(targets_[owner], targets_[k], times)) continue;
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
    const auto here = [&](size_t other) { return same_region(targets_[other], targets_[*next]); };
    match_again(*next, static_cast<size_t>(std::count_if(next, lost.end(), here)));
  }
  std::vector<size_t> replaced;
  for (const size_t k : expected) {
    Target& target = targets_[k];
    if (target.match.status != Status::kSeen || !target.tracker.identity().doubtful(times.pair)) continue;
    StereoTracker::Found found =
        target.tracker.match(times, target.views[0], target.views[1], others_of(k, group, times, target.views));
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
  keep_nearest_jumps(without, targets_);
  // What is too far away to be a jump is left to a target that is lost, now or when it can be measured.
  for (const size_t k : without) {
    StereoMatch& match = targets_[k].match;
    if (lost.empty() || match.status != Status::kOutsidePredictionGate || may_be_jump(targets_[k], times)) continue;
    match = {};
    match.status = Status::kOtherTarget;
  }
  for (const size_t k : group) {
    Target& target = targets_[k];
    target.found_inside_windows =
        target.tracker.is_inside_windows(times, target.match, target.views[0], target.views[1]);
  }
}

}  // namespace multireach::vision
