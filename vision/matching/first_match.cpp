#include "vision/matching/first_match.hpp"

namespace multireach::vision {
namespace {

/// Whether the distance exceeds its standard deviation.
bool has_distance(const StereoMatch& match, const StereoRig& rig) {
  const Eigen::Vector3d line = match.point.p_W - rig.X_WL.translation(), along = line.normalized();
  return along.dot(match.covariance() * along) < line.squaredNorm();
}

}  // namespace

void refuse_unlikely_first_match(const PairContext& pair, size_t chosen, std::span<const ComparedPair> compared,
                                 size_t others_in_left, TargetMatch& found) {
  using Status = StereoMatch::Status;
  const bool known = pair.options.match.radius_m > 0;
  Candidate& candidate = found.candidates[chosen];
  const auto refuse = [&](const StereoMatch& match, Status status, const char* reason) {
    found.match = match;
    found.match.status = status;
    candidate.chosen = false;
    candidate.reason = reason;
  };
  if (known && !fits_known_radius(candidate)) {
    const auto& term = candidate.evidence.term;
    const bool wrong_size = term[Evidence::kSize] < term[Evidence::kStereo];
    refuse(candidate.match, wrong_size ? Status::kWrongRadius : Status::kInconsistentPair,
           "its size and its two images hardly fit");
    return;
  }
  const Appearance& in_left = pair.left.appearance[static_cast<size_t>(candidate.match.left)];
  const Appearance& in_right = pair.right.appearance[static_cast<size_t>(candidate.match.right)];
  if (!known && !is_likely(candidate.match, candidate.radius_px, in_left, in_right)) {
    refuse(candidate.match, Status::kUnlikely, "it is too small or too ragged for a first match");
    return;
  }
  if (!has_distance(candidate.match, pair.options.rig)) {
    refuse(candidate.match, Status::kNoDistance, description(Status::kNoDistance));
    return;
  }
  const ComparedPair* other = known ? nullptr : contradiction_of(compared, pair.options.rig, others_in_left);
  if (other) {
    refuse(other->match, other->match.status,
           "more contours violate the epipolar constraint than fit: it may fit by chance");
    return;
  }
  const TargetIdentity& identity = pair.object.identity;
  const double seen_radius_m = identity.known() ? identity.appearance(pair.times.pair).radius_m : 0;
  const ComparedPair* better =
      outdone_by(candidate, found.candidates, compared, {pair.left.contours, pair.right.contours},
                 {pair.left.appearance, pair.right.appearance}, seen_radius_m, pair.options.match);
  if (better) {
    const bool cut_off = better->match.status == Status::kCutOff;
    refuse(better->match, cut_off ? Status::kMoreAtBorder : better->match.status,
           cut_off ? "both images show something more like the target, which the border cuts off"
                   : "both images show something more like the target, which fits no pair");
  }
}

}  // namespace multireach::vision
