#include "vision/matching/wider_colours.hpp"

#include <algorithm>
#include <array>

namespace multireach::vision {
namespace {

constexpr int64_t kWiderFor = 2000000;  // us since the last match by the learned colours

/// Whether nothing that the learned colours show is the target, or only what is not where it is expected.
bool shows_no_target(StereoMatch::Status status) {
  using Status = StereoMatch::Status;
  static constexpr std::array kNoTarget{Status::kNotInLeft,     Status::kNotInRight,      Status::kInconsistentPair,
                                        Status::kOutsideRegion, Status::kNoDistance,      Status::kOnlyBackground,
                                        Status::kUnlike,        Status::kUnlikely,        Status::kOffColour,
                                        Status::kOtherTarget,   Status::kSeveralElsewhere};
  return std::ranges::find(kNoTarget, status) != kNoTarget.end();
}

}  // namespace

bool may_show_more(const TrackerOptions& options, const TrackedObject& object, int64_t utime,
                   const StereoMatch& match) {
  const auto seen = object.track.last_seen_utime();
  if (!shows_no_target(match.status) || !seen || utime - object.identity.last_utime() > kWiderFor) return false;
  return !(static_cast<double>(utime - *seen) > 1e6 * options.track.coast_s);
}

bool is_target_again(const TrackerOptions& options, const TargetMatch& found, const View& left, const View& right) {
  const StereoMatch& match = found.match;
  if (match.status != StereoMatch::Status::kSeen || found.candidates.empty()) return false;
  const bool is_ball = options.match.radius_m > 0;
  const bool looks_like_it =
      match.both_by_contour || (!is_ball && left.is_compact(match.left) && right.is_compact(match.right));
  return looks_like_it && found.candidates.front().evidence.term[Evidence::kSize] > Evidence::kOtherSize;
}

}  // namespace multireach::vision
