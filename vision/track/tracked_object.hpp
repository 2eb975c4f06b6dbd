#pragma once

#include <Eigen/Core>

#include "vision/track/target_identity.hpp"
#include "vision/track/target_track.hpp"
#include "vision/track/unoccluded_size.hpp"

namespace multireach::vision {

/// What is known of an object between two pairs of images.
struct TrackedObject {
  TargetTrack track;
  TargetIdentity identity{};
  double radius_m = 0;  ///< the known one, else as measured by the last match; 0 before the first
  UnoccludedSize unoccluded_size{};
  /// StereoMatch::shape_covariance of the last match: as uncertain is what coasts.
  Eigen::Matrix3d shape_covariance = Eigen::Matrix3d::Zero();
};

}  // namespace multireach::vision
