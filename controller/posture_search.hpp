#pragma once

#include <cstdint>
#include <optional>

#include "controller/shoulder_elbow.hpp"
#include "kinematics/chain.hpp"

namespace multireach::controller {

struct PostureSearchOptions {
  int samples = 121;          ///< angles of the third joint tried per curve, where there is a closed form
  int starts = 32;            ///< random postures to start from, where there is none
  uint64_t seed = 1;          ///< of those postures; the same seed finds the same posture
  double tolerance_m = 1e-7;  ///< a posture reaches a point when its tip is this near
};

/// Finds, among all postures inside the limits whose tip is at a given point, one nearest to a given posture: the
/// first theta_T of Sect. 3.4. In closed form for a shoulder-elbow arm; by damped Newton steps from many seeded starts,
/// each then drawn along its self-motion towards the given posture, for any other.
class PostureSearch {
 public:
  explicit PostureSearch(const Chain& chain, const PostureSearchOptions& options = {});

  /// Nothing when no posture was found: the point is out of reach (or, for an arm without closed form, so hard to reach
  /// that no start led there).
  std::optional<JointVector> nearest(const Eigen::Vector3d& x_T, const JointVector& theta) const;
  bool closed_form() const { return shoulder_elbow_.has_value(); }

 private:
  bool solve(const Eigen::Vector3d& x_T, JointVector& posture) const;
  void approach(const Eigen::Vector3d& x_T, const JointVector& theta, JointVector& posture) const;
  std::optional<JointVector> multi_start(const Eigen::Vector3d& x_T, const JointVector& theta) const;

  Chain chain_;
  PostureSearchOptions options_;
  std::optional<ShoulderElbow> shoulder_elbow_;
};

}  // namespace multireach::controller
