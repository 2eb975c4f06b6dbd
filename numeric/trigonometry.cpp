#include "numeric/trigonometry.hpp"

#include <algorithm>

namespace multireach {

// The formula of Eigen::Quaterniond::FromTwoVectors, and its bits. Eigen's own takes nine seconds to compile wherever
// it is used, for the singular value decomposition with which it finds an axis for opposite vectors.
Eigen::Matrix3d rotation_from_z(const Eigen::Vector3d& direction) {
  constexpr double kOpposite = 1e-12;
  const Eigen::Vector3d to = direction.normalized();
  const double cosine = to.z();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ().cross(to);
  Eigen::Quaterniond turn;
  if (cosine < -1 + kOpposite) {
    axis = axis.isZero(0) ? Eigen::Vector3d(-Eigen::Vector3d::UnitX()) : axis.normalized();
    const double w2 = 0.5 * (1 + std::max(cosine, -1.0));
    turn.w() = std::sqrt(w2);
    turn.vec() = axis * std::sqrt(1 - w2);
  } else {
    const double s = std::sqrt((1 + cosine) * 2);
    turn.vec() = axis * (1 / s);
    turn.w() = 0.5 * s;
  }
  return turn.toRotationMatrix();
}

}  // namespace multireach
