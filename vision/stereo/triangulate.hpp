#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "imaging/stereo_rig.hpp"

namespace multireach::vision {

/// A direction (x/z, y/z) in a camera's frame, undistorted, with the covariance of its errors.
struct RayMeasurement {
  Eigen::Vector2d ray;
  Eigen::Matrix2d covariance;
};

/// Independent errors of `sigma_px` pixels in each coordinate, as a covariance of (x/z, y/z).
Eigen::Matrix2d ray_covariance(const CameraModel& camera, double sigma_px);

/// What one camera tells about a sphere: (x/z, y/z, s), the direction to its centre and the sine of its angular radius
/// (its radius over its centre's distance), with their covariance.
struct SphereMeasurement {
  Eigen::Vector3d value;
  Eigen::Matrix3d covariance;
};

struct Triangulation {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();         ///< the point, m, in W
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of p_W, m^2
  double depth_left_m = 0;                               ///< z in the left camera's frame
  double depth_right_m = 0;
  double epipolar_error_px = 0;  ///< distance of the two rays at the point, in pixels of the left camera
  double chi2 = 0;               ///< sum of squared residuals in units of their standard deviations
  int degrees_of_freedom = 1;    ///< of chi2: its mean when the measurements are of one object
};

/// The point in space whose images are nearest to two undistorted image points: least squares, each point weighed by
/// its covariance, by Gauss-Newton steps from the midpoint of the rays, with the covariance (J^T S^-1 J)^-1 (Hartley &
/// Zisserman, Multiple View Geometry, 2nd ed., Sect. 5.2 and 12.3). Nothing when the rays are parallel or the point is
/// not in front of both cameras.
std::optional<Triangulation> triangulate(const StereoRig& rig, const RayMeasurement& left, const RayMeasurement& right);

/// What is known of a sphere's radius before it is seen, m.
struct RadiusPrior {
  double radius_m = 0;
  double sigma_m = 0;  ///< how far the radius that is seen may be from it: tolerance of the ball, blur of its outline
};

struct SphereTriangulation : Triangulation {
  double radius_m = 0;        ///< as seen, the prior included
  double radius_sigma_m = 0;  ///< its standard deviation
};

/// The same for a sphere: its centre and radius from both directions and both angular radii. That both cameras see a
/// sphere of one size, and a known radius, help where a direction is unsure (a hidden part), and chi2 tells when they
/// contradict one another.
std::optional<SphereTriangulation> triangulate_sphere(const StereoRig& rig, const SphereMeasurement& left,
                                                      const SphereMeasurement& right,
                                                      const std::optional<RadiusPrior>& prior);

}  // namespace multireach::vision
