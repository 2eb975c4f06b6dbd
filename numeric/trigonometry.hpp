#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "numeric/lanes.hpp"

namespace multireach {

// The C library selects its sine and arc tangent by processor, and the variants differ in the last bit. These functions
// use only additions, multiplications, divisions and square roots, which IEEE 754 defines: the same bits everywhere.

/// Sine and cosine, with an absolute error of at most 1e-15; NaN for an angle that is not finite.
inline void sine_and_cosine_of(double angle, double& sine, double& cosine) {
  // std::remainder is exact, so it gives the same bits everywhere.
  if (!(std::abs(angle) <= kMaxAngle)) angle = std::remainder(angle, 2 * std::numbers::pi);
  if (std::isnan(angle)) {
    sine = cosine = angle;
    return;
  }
  sine_and_cosine(angle, sine, cosine);
}

/// atan2(y, x), from -pi to pi, with error at most 1e-15; 0 for the origin, NaN for arguments that are not finite.
inline double arc_tangent(double y, double x) {
  return std::isfinite(x) && std::isfinite(y) ? finite_arc_tangent(y, x) : std::nan("");
}

/// acos, from 0 to pi, of a cosine from -1 to 1.
inline double arc_cosine(double cosine) {
  return arc_tangent(std::sqrt((1 - cosine) * (1 + cosine)), cosine);
}

/// Rotation matrix about a unit axis.
inline Eigen::Matrix3d rotation_about(const Eigen::Vector3d& axis, double angle) {
  double s, c;
  sine_and_cosine_of(angle, s, c);
  const double v = 1 - c, x = axis.x(), y = axis.y(), z = axis.z();
  Eigen::Matrix3d R;
  R << c + v * x * x, v * x * y - s * z, v * x * z + s * y,  //
      v * y * x + s * z, c + v * y * y, v * y * z - s * x,   //
      v * z * x - s * y, v * z * y + s * x, c + v * z * z;
  return R;
}

/// The rotation by the smallest angle that turns z to `direction`, which need not be a unit vector.
Eigen::Matrix3d rotation_from_z(const Eigen::Vector3d& direction);

/// Rotation matrix from URDF's roll, pitch and yaw: about the fixed axes x, then y, then z.
inline Eigen::Matrix3d rotation_from_rpy(const Eigen::Vector3d& rpy) {
  return rotation_about(Eigen::Vector3d::UnitZ(), rpy.z()) * rotation_about(Eigen::Vector3d::UnitY(), rpy.y()) *
         rotation_about(Eigen::Vector3d::UnitX(), rpy.x());
}

}  // namespace multireach
