#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "numeric/lanes.hpp"

namespace multireach {

// The C library chooses its sine and arc tangent by the processor, and they differ in their last bit. These are made of
// additions, multiplications, divisions and square roots alone, which IEEE 754 defines: the same bits everywhere.

/// Sine and cosine, to 1e-15 absolutely; NaN for what is not finite.
inline void sine_and_cosine_of(double angle, double& sine, double& cosine) {
  // std::remainder is exact.
  if (!(std::abs(angle) <= kLargestAngle)) angle = std::remainder(angle, 2 * std::numbers::pi);
  if (std::isnan(angle)) {
    sine = cosine = angle;
    return;
  }
  sine_and_cosine(angle, sine, cosine);
}

/// The angle of the point (x, y), from -pi to pi, to 1e-15; 0 for the origin, NaN for what is not finite.
inline double arc_tangent(double y, double x) {
  return std::isfinite(x) && std::isfinite(y) ? finite_arc_tangent(y, x) : std::nan("");
}

/// The angle from 0 to pi with this cosine, which is from -1 to 1.
inline double arc_cosine(double cosine) {
  return arc_tangent(std::sqrt((1 - cosine) * (1 + cosine)), cosine);
}

/// The rotation about a unit axis.
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

/// Roll, pitch and yaw, as URDF has them: about the fixed axes x, then y, then z.
inline Eigen::Matrix3d rotation_from_rpy(const Eigen::Vector3d& rpy) {
  return rotation_about(Eigen::Vector3d::UnitZ(), rpy.z()) * rotation_about(Eigen::Vector3d::UnitY(), rpy.y()) *
         rotation_about(Eigen::Vector3d::UnitX(), rpy.x());
}

}  // namespace multireach
