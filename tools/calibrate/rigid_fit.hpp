#pragma once

#include <Eigen/Geometry>

namespace multireach {

/// The rigid transform X that moves the columns of `from` nearest to those of `to`: least sum of squared distances, no
/// scale (Kabsch 1976; Umeyama, PAMI 1991). At least 3 columns that are on no line.
inline Eigen::Isometry3d rigid_fit(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  return Eigen::Isometry3d(Eigen::umeyama(from, to, false));
}

}  // namespace multireach
