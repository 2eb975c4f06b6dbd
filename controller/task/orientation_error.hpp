#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include "numeric/trigonometry.hpp"

namespace multireach::controller {

using Vector3 = std::array<double, 3>;
/// Three columns of a rotation matrix.
using Columns3 = std::array<Vector3, 3>;

inline Columns3 columns_of(const Eigen::Matrix3d& R) {
  Columns3 columns;
  for (int c = 0; c < 3; ++c) columns[c] = {R(0, c), R(1, c), R(2, c)};
  return columns;
}

inline double norm(const Vector3& a) {
  return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

/// The rotation vector (unit axis times angle, at most pi) in W that turns `from` into `to`. At half a turn it returns
/// one of the two solutions.
inline Vector3 rotation_vector(const Columns3& from, const Columns3& to) {
  double E[3][3];
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) E[r][c] = to[0][r] * from[0][c] + to[1][r] * from[1][c] + to[2][r] * from[2][c];
  }
  Vector3 w{0.5 * (E[2][1] - E[1][2]), 0.5 * (E[0][2] - E[2][0]), 0.5 * (E[1][0] - E[0][1])};
  const double sine = norm(w), cosine = 0.5 * (E[0][0] + E[1][1] + E[2][2] - 1);
  if (sine > 1e-7) {
    const double scale = arc_tangent(sine, cosine) / sine;
    for (double& element : w) element *= scale;
  } else if (cosine < 0) {  // E = 2 a a^T - I for the unit axis a
    int k = E[1][1] > E[0][0] ? 1 : 0;
    if (E[2][2] > E[k][k]) k = 2;
    const double along = std::sqrt(std::max(0.5 * (E[k][k] + 1), 0.25));
    for (int r = 0; r < 3; ++r) w[r] = std::numbers::pi * (r == k ? along : 0.25 * (E[r][k] + E[k][r]) / along);
  }
  return w;
}

/// The shortest rotation vector in W that turns the unit vector `from` into `to`. When they are opposite, it turns
/// about `otherwise`, a unit vector perpendicular to `from`.
inline Vector3 pointing_vector(const Vector3& from, const Vector3& to, const Vector3& otherwise) {
  Vector3 w{from[1] * to[2] - from[2] * to[1], from[2] * to[0] - from[0] * to[2], from[0] * to[1] - from[1] * to[0]};
  const double sine = norm(w), cosine = from[0] * to[0] + from[1] * to[1] + from[2] * to[2];
  if (sine > 1e-7) {
    const double scale = arc_tangent(sine, cosine) / sine;
    for (double& element : w) element *= scale;
  } else if (cosine < 0) {
    for (int k = 0; k < 3; ++k) w[k] = std::numbers::pi * otherwise[k];
  }
  return w;
}

}  // namespace multireach::controller
