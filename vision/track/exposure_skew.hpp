#pragma once

#include <Eigen/Core>

#include "imaging/stereo_rig.hpp"

namespace multireach::vision {

/// (m/s)^2, covariance of the velocity of a target that is not tracked, in any frame. With it, the position of a first
/// match has the errors that its motion between the exposures causes. 0.5 m/s in each direction is a choice: most
/// targets begin at rest, or are carried. A thrown one is off by more in its first match if the exposures differ.
Eigen::Matrix3d unknown_velocity_covariance();

/// m^2, in W: covariance of a position `p_W` (m) that was triangulated as if the target were at rest, although the
/// right image was taken `later_s` seconds after the left one; its velocity has the covariance `velocity_covariance`
/// ((m/s)^2). A motion e across the line of sight between the exposures looks like an error e Z / B along it.
Eigen::Matrix3d covariance_of_skew(const StereoRig& rig, const Eigen::Vector3d& p_W,
                                   const Eigen::Matrix3d& velocity_covariance, double later_s);

}  // namespace multireach::vision
