#pragma once

#include "imaging/side.hpp"
#include "imaging/stereo_rig.hpp"

namespace multireach {

/// Derivative of the images of a position (m, in the left camera's frame), x and y in the left camera, then in the
/// right one, pixels, with respect to the errors of the calibration, in the order of RigErrors. For z > 0 in both
/// cameras.
Eigen::Matrix<double, 4, RigErrors::kCount> d_pixels_d_errors(const StereoRig& rig, const Eigen::Vector3d& p_L);

/// Derivative of a triangulated position (m, in the left camera's frame) with respect to the errors of the calibration,
/// in the order of RigErrors: both images stay, and the position that fits them best, in pixels, moves. Zero where a
/// camera does not see the position (z <= 0) or its lens model ends.
Eigen::Matrix<double, 3, RigErrors::kCount> d_position_d_errors(const StereoRig& rig, const Eigen::Vector3d& p_L);

/// Covariance (m^2, in W) of a position (m, in W) by the errors of the calibration alone. They are the same in every
/// image, so filtering does not reduce them. Zero where they are not known.
Eigen::Matrix3d covariance_by_rig_errors(const StereoRig& rig, const Eigen::Vector3d& p_W);
/// The same for a position that the image of one camera tells, by the known size of what it shows.
Eigen::Matrix3d covariance_by_rig_errors(const StereoRig& rig, Side side, const Eigen::Vector3d& p_W);

/// Variance of the size of a thing at `p_W` by the errors of the calibration, relative: its size in the images, times
/// its distance by triangulation.
double size_variance_by_rig_errors(const StereoRig& rig, const Eigen::Vector3d& p_W);

}  // namespace multireach
