#include "imaging/rig_errors.hpp"

#include <Eigen/Cholesky>

#include "imaging/lens.hpp"

namespace multireach {
namespace {

using Derivative = Eigen::Matrix<double, 3, RigErrors::kCount>;

Eigen::Matrix<double, 2, 3> d_ray_d_point(const Eigen::Vector3d& p) {
  Eigen::Matrix<double, 2, 3> J;
  J << 1 / p.z(), 0, -p.x() / (p.z() * p.z()), 0, 1 / p.z(), -p.y() / (p.z() * p.z());
  return J;
}

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// The images of a position and their derivatives.
struct Images {
  Eigen::Vector3d p_R;
  LensPoint left, right;
  Eigen::Matrix<double, 2, 3> right_by_point;  // in the right camera's frame

  Images(const StereoRig& rig, const Eigen::Vector3d& p_L)
      : p_R(rig.X_RL * p_L),
        left(image_of(rig.left, p_L.hnormalized())),
        right(image_of(rig.right, p_R.hnormalized())),
        right_by_point(right.d_pixel_d_ray * d_ray_d_point(p_R)) {}

  Eigen::Matrix<double, 4, RigErrors::kCount> by_errors(const StereoRig& rig) const {
    Eigen::Matrix<double, 4, RigErrors::kCount> J = Eigen::Matrix<double, 4, RigErrors::kCount>::Zero();
    J.col(RigErrors::kFocalLength) << left.pixel - Eigen::Vector2d(rig.left.cx, rig.left.cy),
        right.pixel - Eigen::Vector2d(rig.right.cx, rig.right.cy);
    // The right camera at (1 + error) times its distance from the left one: x_R = R x_L + (1 + error) t.
    J.block<2, 1>(2, RigErrors::kBaseline) = right_by_point * rig.X_RL.translation();
    J.block<2, 3>(2, RigErrors::kRotationX) = -right_by_point * cross(p_R);
    return J;
  }
};

}  // namespace

Eigen::Matrix<double, 4, RigErrors::kCount> d_pixels_d_errors(const StereoRig& rig, const Eigen::Vector3d& p_L) {
  return Images(rig, p_L).by_errors(rig);
}

Derivative d_position_d_errors(const StereoRig& rig, const Eigen::Vector3d& p_L) {
  if (!(p_L.z() > 0 && (rig.X_RL * p_L).z() > 0)) return Derivative::Zero();
  const Images images(rig, p_L);
  Eigen::Matrix<double, 4, 3> by_position;
  by_position << images.left.d_pixel_d_ray * d_ray_d_point(p_L), images.right_by_point * rig.X_RL.linear();
  const Eigen::Matrix3d information = by_position.transpose() * by_position;
  const Derivative moved = -information.ldlt().solve(by_position.transpose() * images.by_errors(rig));
  return moved.allFinite() ? moved : Derivative::Zero();
}

Eigen::Matrix3d covariance_by_rig_errors(const StereoRig& rig, const Eigen::Vector3d& p_W) {
  if (!rig.errors.known()) return Eigen::Matrix3d::Zero();
  const Derivative moved = rig.X_WL.linear() * d_position_d_errors(rig, rig.X_WL.inverse() * p_W);
  return moved * rig.errors.covariance * moved.transpose();
}

Eigen::Matrix3d covariance_by_rig_errors(const StereoRig& rig, Side side, const Eigen::Vector3d& p_W) {
  if (!rig.errors.known()) return Eigen::Matrix3d::Zero();
  const bool left = side == Side::kLeft;
  const Eigen::Isometry3d X_CW = left ? rig.X_WL.inverse() : rig.X_RL * rig.X_WL.inverse();
  const Eigen::Vector3d p_C = X_CW * p_W;
  Derivative moved = Derivative::Zero();  // in the camera's frame
  // The size in the image tells z / f; x / z * f and y / z * f stay.
  moved(2, RigErrors::kFocalLength) = p_C.z();
  if (!left) {
    moved.col(RigErrors::kBaseline) = -rig.X_RL.translation();
    moved.rightCols<3>() = cross(p_C);
  }
  moved = (X_CW.linear().transpose() * moved).eval();
  return moved * rig.errors.covariance * moved.transpose();
}

double size_variance_by_rig_errors(const StereoRig& rig, const Eigen::Vector3d& p_W) {
  if (!rig.errors.known()) return 0;
  const Eigen::Vector3d p_L = rig.X_WL.inverse() * p_W;
  Eigen::Matrix<double, 1, RigErrors::kCount> size =
      p_L.transpose() * d_position_d_errors(rig, p_L) / p_L.squaredNorm();
  size[RigErrors::kFocalLength] -= 1;  // of the angle that it covers
  return size * rig.errors.covariance * size.transpose();
}

}  // namespace multireach
