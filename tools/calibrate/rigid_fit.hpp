#pragma once

#include <Eigen/Geometry>

namespace multireach {

/// The rigid transform X that maps the columns of `from` to those of `to` with the least sum of squared distances, no
/// scale (Kabsch 1976; Umeyama, PAMI 1991). Needs at least 3 columns that are not collinear.
inline Eigen::Isometry3d rigid_fit(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  return Eigen::Isometry3d(Eigen::umeyama(from, to, false));
}

}  // namespace multireach
