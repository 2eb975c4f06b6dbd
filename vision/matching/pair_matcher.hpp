#pragma once

#include <array>
#include <vector>

#include "vision/matching/target_match.hpp"
#include "vision/pair_times.hpp"
#include "vision/tracked_object.hpp"
#include "vision/tracker_options.hpp"
#include "vision/view.hpp"

namespace multireach::vision {

/// Chooses which blobs in two views of one pair are the object, and locates it. Changes nothing of what is known of the
/// object. All arguments must live as long as the matcher.
class PairMatcher {
 public:
  PairMatcher(const TrackerOptions& options, const TrackedObject& object, const PairTimes& times, const View& left,
              const View& right)
      : options_(options), object_(object), times_(times), left_(left), right_(right) {}

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
                                    const Scope& scope) const;
  void check(bool expected, ComparedPair& pair) const;
  double lead_against_found_again() const;

  const TrackerOptions& options_;
  const TrackedObject& object_;
  const PairTimes& times_;
  const View &left_, &right_;
};

}  // namespace multireach::vision
