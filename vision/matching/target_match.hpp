#pragma once

#include <array>
#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "vision/stereo/stereo_match.hpp"
#include "vision/track/candidates.hpp"

namespace multireach::vision {

/// What a pair shows of the other targets that look like one.
struct OtherTargets {
  std::array<std::vector<bool>, 2> taken{};  ///< for each blob of the views, whether it is another target; or empty
  size_t sought = 1;            ///< how many targets that look like this one are looked for, itself included
  bool unknown = false;         ///< there are others, but which blobs they are is not known yet
  size_t sought_elsewhere = 1;  ///< the same, of those that are not where they are expected
  bool anywhere = false;        ///< this target is looked for wherever it may be, not where its motion takes it
};

/// What encloses the other targets that look like this one, in the left and the right image.
using BoxesOfOthers = std::array<std::vector<cv::Rect>, 2>;

/// A match with the candidates that it was chosen from, best first. Where several could be the target, its status is
/// kAmbiguous and it is the best one.
struct TargetMatch {
  StereoMatch match;
  std::vector<Candidate> candidates;
  std::optional<StereoMatch> replaces{};  ///< the match of the followed object, which `match` is to replace
};

}  // namespace multireach::vision
