#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "vision/camera_model.hpp"

namespace multireach::vision {

/// Two cameras fixed to each other and to the robot.
struct StereoRig {
  CameraModel left, right;
  Eigen::Isometry3d X_RL;  ///< left camera's frame to right camera's (OpenCV's R and T of a stereo calibration)
  Eigen::Isometry3d X_WL;  ///< left camera's frame to the robot's base

  double baseline_m() const { return X_RL.translation().norm(); }
};

struct Triangulation {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();         ///< the point, m, in W
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of p_W, m^2
  double depth_left_m = 0;                               ///< z in the left camera's frame
  double depth_right_m = 0;
  double epipolar_error_px = 0;  ///< distance of the two rays at the point, in pixels of the left camera
};

/// The point in space whose images are nearest to two undistorted image points, given as rays (x/z, y/z) of each
/// camera: least squares in pixels by Gauss-Newton steps from the midpoint of the rays, with the covariance sigma^2
/// (J^T J)^-1 for independent errors of `sigma_px` in each coordinate (Hartley & Zisserman, Multiple View Geometry, 2nd
/// ed., Sect. 5.2 and 12.3). Nothing when the rays are parallel or the point is not in front of both cameras.
std::optional<Triangulation> triangulate(const StereoRig& rig, const Eigen::Vector2d& left_ray,
                                         const Eigen::Vector2d& right_ray, double sigma_px);

}  // namespace multireach::vision
