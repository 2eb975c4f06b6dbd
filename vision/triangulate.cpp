#include "vision/triangulate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

namespace multireach::vision {
namespace {

/// Adds one camera's part of the normal equations: residuals and Jacobian of the image of `p_L` in pixels.
void accumulate(const CameraModel& camera, const Eigen::Isometry3d& X_CL, const Eigen::Vector3d& p_L,
                const Eigen::Vector2d& ray, Eigen::Matrix3d& JtJ, Eigen::Vector3d& Jtr) {
  const Eigen::Vector3d p = X_CL * p_L;
  const Eigen::Vector2d focal(camera.fx, camera.fy);
  Eigen::Matrix<double, 2, 3> projection;
  projection << 1 / p.z(), 0, -p.x() / (p.z() * p.z()), 0, 1 / p.z(), -p.y() / (p.z() * p.z());
  const Eigen::Matrix<double, 2, 3> J = focal.asDiagonal() * projection * X_CL.linear();
  const Eigen::Vector2d r = focal.cwiseProduct(ray - p.head<2>() / p.z());
  JtJ += J.transpose() * J;
  Jtr += J.transpose() * r;
}

}  // namespace

std::optional<Triangulation> triangulate(const StereoRig& rig, const Eigen::Vector2d& left_ray,
                                         const Eigen::Vector2d& right_ray, double sigma_px) {
  const Eigen::Vector3d a = left_ray.homogeneous(), b = rig.X_RL.linear().transpose() * right_ray.homogeneous();
  const Eigen::Vector3d right_L = rig.X_RL.inverse().translation();
  // The points nearest to each other on both rays: s a and right_L + t b.
  const Eigen::Vector3d normal = a.cross(b);
  const double area2 = normal.squaredNorm();
  if (!(area2 > 1e-18)) return std::nullopt;
  const double s = right_L.cross(b).dot(normal) / area2, t = right_L.cross(a).dot(normal) / area2;
  if (!(s > 0 && t > 0)) return std::nullopt;
  Eigen::Vector3d p_L = 0.5 * (s * a + right_L + t * b);

  const Eigen::Isometry3d X_LL = Eigen::Isometry3d::Identity();
  Eigen::Matrix3d JtJ;
  constexpr int kSteps = 4;  // converges quadratically from an error that is already second order in the noise
  for (int k = 0; k <= kSteps; ++k) {
    JtJ.setZero();
    Eigen::Vector3d Jtr = Eigen::Vector3d::Zero();
    accumulate(rig.left, X_LL, p_L, left_ray, JtJ, Jtr);
    accumulate(rig.right, rig.X_RL, p_L, right_ray, JtJ, Jtr);
    if (k < kSteps) p_L += JtJ.ldlt().solve(Jtr);
  }
  Triangulation result;
  result.depth_left_m = p_L.z();
  result.depth_right_m = (rig.X_RL * p_L).z();
  if (!p_L.allFinite() || result.depth_left_m <= 0 || result.depth_right_m <= 0) return std::nullopt;
  const Eigen::Matrix3d R_WL = rig.X_WL.linear();
  result.p_W = rig.X_WL * p_L;
  result.covariance = sigma_px * sigma_px * R_WL * JtJ.inverse() * R_WL.transpose();
  result.epipolar_error_px = (s * a - right_L - t * b).norm() * rig.left.fx / p_L.z();
  return result;
}

}  // namespace multireach::vision
