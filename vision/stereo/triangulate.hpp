#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "imaging/stereo_rig.hpp"
#include "vision/contour/shared_errors.hpp"

namespace multireach::vision {

/// An undistorted viewing ray (x/z, y/z) in a camera's frame, with its covariance.
struct RayMeasurement {
  Eigen::Vector2d ray;
  Eigen::Matrix2d covariance;
};

/// Covariance of (x/z, y/z) for independent errors of `sigma_px` pixels in each coordinate.
Eigen::Matrix2d ray_covariance(const CameraModel& camera, double sigma_px);

/// One camera's measurement of a sphere: (x/z, y/z, s), the direction to its centre and the sine of its angular radius
/// (radius / distance of the centre), with their covariance and the part of it that the other image shares.
struct SphereMeasurement {
  Eigen::Vector3d value;
  Eigen::Matrix3d covariance;                  ///< includes shared * shared^T
  SharedErrors shared = SharedErrors::Zero();  ///< of one cause each, that acts on both images
};

struct Triangulation {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();         ///< the point, m, in W
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of p_W, m^2
  double depth_left_m = 0;                               ///< z in the left camera's frame
  double depth_right_m = 0;
  double epipolar_error_px = 0;  ///< distance between the two rays at the point, in pixels of the left camera
  double chi2 = 0;               ///< sum of squared residuals in units of their standard deviations
  int degrees_of_freedom = 1;    ///< of chi2; equals its mean when both measurements show one object
};

/// The points of two undistorted viewing rays, of the left and of the right camera, where they are closest, m, in W.
/// Nothing when they are parallel or do not approach each other in front of both cameras.
[[nodiscard]] std::optional<std::array<Eigen::Vector3d, 2>> closest_points(const StereoRig& rig,
                                                                           const Eigen::Vector2d& left_ray,
                                                                           const Eigen::Vector2d& right_ray);

/// Triangulates two undistorted image points: weighted least squares on the reprojection error, with Gauss-Newton steps
/// from the midpoint of the rays. The covariance is (J^T S^-1 J)^-1 (Hartley & Zisserman, Multiple View Geometry,
/// 2nd ed., Sect. 5.2 and 12.3). Nothing when the rays are parallel, the steps do not converge, as where the estimate
/// goes to infinity, or the point is not in front of both cameras.
[[nodiscard]] std::optional<Triangulation> triangulate(const StereoRig& rig, const RayMeasurement& left,
                                                       const RayMeasurement& right);

/// Prior of a sphere's radius.
struct RadiusPrior {
  double radius_m = 0;
  double sigma_m = 0;  ///< standard deviation of the measured radius from it: the ball's tolerance, the contour's blur
};

struct SphereTriangulation : Triangulation {
  double radius_m = 0;        ///< estimate, including the prior
  double radius_sigma_m = 0;  ///< standard deviation of `radius_m`
};

/// Triangulates a sphere: its centre and radius from both directions and both angular radii, by generalised least
/// squares: the errors of both images correlate by what they share. The common size, and a known radius, improve the
/// estimate where a direction is uncertain (partial occlusion); a large chi2 indicates that the measurements contradict
/// each other. Nothing as above.
[[nodiscard]] std::optional<SphereTriangulation> triangulate_sphere(const StereoRig& rig, const SphereMeasurement& left,
                                                                    const SphereMeasurement& right,
                                                                    const std::optional<RadiusPrior>& prior);

/// Covariance of a sphere's centre, m^2, in W, by the linearisation at an estimate of its centre (m, in W) and its
/// radius, without a prior. At one estimate, larger measurement covariances never give a smaller one.
[[nodiscard]] Eigen::Matrix3d sphere_covariance_at(const StereoRig& rig, const Eigen::Vector3d& p_W, double radius_m,
                                                   const SphereMeasurement& left, const SphereMeasurement& right);

}  // namespace multireach::vision
