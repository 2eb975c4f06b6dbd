#include "numeric/trigonometry.hpp"

namespace multireach {

// Not inline: Eigen's singular value decomposition, which this uses for opposite vectors, takes nine seconds to
// compile.
Eigen::Matrix3d rotation_from_z(const Eigen::Vector3d& direction) {
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), direction).toRotationMatrix();
}

}  // namespace multireach
