#include "vision/association/solid_targets.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numbers>

namespace multireach::vision {
namespace {

using Target = StereoVision::Target;

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
  return std::min(a.tracker.object().radius_m, b.tracker.object().radius_m);
}

/// Position of `b` relative to `a` when both were seen last, m, in W.
Eigen::Vector3d relative_when_seen(const TargetTrack& a, const TargetTrack& b) {
  const int64_t seen = std::min(*a.last_seen_utime(), *b.last_seen_utime());
  return b.position_at(seen) - a.position_at(seen);
}

/// m^2, of how far a target has moved to a match: a bias that only the track has looks like motion.
Eigen::Matrix3d covariance_of_change(const Target& target, const StereoMatch& match) {
  Eigen::Matrix3d covariance = match.noise_covariance();
  if (match.both_by_contour) covariance += target.tracker.track().estimate().bias_covariance;
  return covariance;
}

}  // namespace

bool pass_through(const Target& a, const StereoMatch& match_a, const Target& b, const StereoMatch& match_b) {
  return pass_through(relative_when_seen(a.tracker.track(), b.tracker.track()), match_b.point.p_W - match_a.point.p_W,
                      covariance_of_change(a, match_a) + covariance_of_change(b, match_b), smaller_radius(a, b));
}

bool would_bounce(const Target& a, const Target& b, int64_t utime) {
  const TargetTrack &track_a = a.tracker.track(), &track_b = b.tracker.track();
  const auto at_a = track_a.predicted_steady(utime), at_b = track_b.predicted_steady(utime);
  return at_a && at_b &&
         pass_through(relative_when_seen(track_a, track_b), at_b->position - at_a->position,
                      at_a->covariance + at_b->covariance, smaller_radius(a, b));
}

}  // namespace multireach::vision
