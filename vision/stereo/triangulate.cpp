#include "vision/stereo/triangulate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cmath>

namespace multireach::vision {
namespace {

constexpr int kSteps = 5;  // enough: quadratic convergence from a start whose error is second order in the noise
// Share of the distance by which the last step may still move the estimate. Else it goes to infinity, or far away from
// the measured rays, as that of elongated blobs whose rows contradict each other.
constexpr double kConverged = 1e-3;

bool has_converged(const Eigen::Vector3d& step, const Eigen::Vector3d& p_L) {
  return step.norm() <= kConverged * p_L.norm();
}

/// The closest points of two rays and their midpoint, in the left camera's frame, and the gap between them.
struct Meeting {
  Eigen::Vector3d on_left, on_right, p_L;
  double gap_m;
};

std::optional<Meeting> meeting_of(const StereoRig& rig, const Eigen::Vector2d& left_ray,
                                  const Eigen::Vector2d& right_ray) {
  const Eigen::Vector3d a = left_ray.homogeneous(), b = rig.X_RL.linear().transpose() * right_ray.homogeneous();
  const Eigen::Vector3d right_L = rig.X_RL.inverse().translation();
  // The closest points of both rays are s a and right_L + t b.
  const Eigen::Vector3d normal = a.cross(b);
  const double area2 = normal.squaredNorm();
  if (!(area2 > 1e-18)) return std::nullopt;
  const double s = right_L.cross(b).dot(normal) / area2, t = right_L.cross(a).dot(normal) / area2;
  if (!(s > 0 && t > 0)) return std::nullopt;
  const Eigen::Vector3d on_left = s * a, on_right = right_L + t * b;
  return Meeting{on_left, on_right, 0.5 * (on_left + on_right), (s * a - right_L - t * b).norm()};
}

/// (x/z, y/z) of a point, and its derivative with respect to the point in the left camera's frame.
void project(const Eigen::Isometry3d& X_CL, const Eigen::Vector3d& p_L, Eigen::Vector2d& ray,
             Eigen::Matrix<double, 2, 3>& J) {
  const Eigen::Vector3d p = X_CL * p_L;
  ray = p.head<2>() / p.z();
  J << 1 / p.z(), 0, -p.x() / (p.z() * p.z()), 0, 1 / p.z(), -p.y() / (p.z() * p.z());
  J = (J * X_CL.linear()).eval();
}

bool finish(const StereoRig& rig, const Meeting& meeting, const Eigen::Vector3d& p_L, const Eigen::Matrix3d& covariance,
            Triangulation& result) {
  result.depth_left_m = p_L.z();
  result.depth_right_m = (rig.X_RL * p_L).z();
  if (!p_L.allFinite() || result.depth_left_m <= 0 || result.depth_right_m <= 0) return false;
  const Eigen::Matrix3d R_WL = rig.X_WL.linear();
  result.p_W = rig.X_WL * p_L;
  result.covariance = R_WL * covariance * R_WL.transpose();
  result.epipolar_error_px = meeting.gap_m * rig.left.fx / p_L.z();
  return true;
}

using Joint = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Inverse covariance of both measurements of a sphere.
Joint weight_of(const SphereMeasurement& left, const SphereMeasurement& right) {
  Joint joint;
  joint.topLeftCorner<3, 3>() = left.covariance;
  joint.bottomRightCorner<3, 3>() = right.covariance;
  joint.topRightCorner<3, 3>() = left.shared * right.shared.transpose();
  joint.bottomLeftCorner<3, 3>() = right.shared * left.shared.transpose();
  return joint.ldlt().solve(Joint::Identity());
}

/// Both measurements of a sphere, as expected, and their derivative with respect to `x`: the centre in the left
/// camera's frame, and the radius.
void expect_sphere(const StereoRig& rig, const Eigen::Vector4d& x, Vector6& expected, Eigen::Matrix<double, 6, 4>& J) {
  const std::array cameras{Eigen::Isometry3d::Identity(), rig.X_RL};
  J.setZero();
  for (int side = 0; side < 2; ++side) {
    const Eigen::Isometry3d& X_CL = cameras[static_cast<size_t>(side)];
    const Eigen::Vector3d p_L = x.head<3>(), p_C = X_CL * p_L;
    Eigen::Vector2d ray;
    Eigen::Matrix<double, 2, 3> J_ray;
    project(X_CL, p_L, ray, J_ray);
    const double distance = p_C.norm();
    J.block<2, 3>(3 * side, 0) = J_ray;
    J.block<1, 3>(3 * side + 2, 0) = -x[3] / (distance * distance * distance) * p_C.transpose() * X_CL.linear();
    J(3 * side + 2, 3) = 1 / distance;
    expected.segment<3>(3 * side) << ray, x[3] / distance;
  }
}

}  // namespace

Eigen::Matrix2d ray_covariance(const CameraModel& camera, double sigma_px) {
  const Eigen::Array2d sigma(sigma_px / camera.fx, sigma_px / camera.fy);
  return Eigen::Matrix2d(sigma.square().matrix().asDiagonal());
}

std::optional<std::array<Eigen::Vector3d, 2>> closest_points(const StereoRig& rig, const Eigen::Vector2d& left_ray,
                                                             const Eigen::Vector2d& right_ray) {
  const auto meeting = meeting_of(rig, left_ray, right_ray);
  if (!meeting) return std::nullopt;
  return std::array<Eigen::Vector3d, 2>{rig.X_WL * meeting->on_left, rig.X_WL * meeting->on_right};
}

std::optional<Triangulation> triangulate(const StereoRig& rig, const RayMeasurement& left,
                                         const RayMeasurement& right) {
  const auto meeting = meeting_of(rig, left.ray, right.ray);
  if (!meeting) return std::nullopt;
  const Eigen::Isometry3d X_LL = Eigen::Isometry3d::Identity();
  const Eigen::Matrix2d left_weight = left.covariance.inverse(), right_weight = right.covariance.inverse();
  Eigen::Vector3d p_L = meeting->p_L, step = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information;
  Triangulation result;
  for (int k = 0; k <= kSteps; ++k) {
    information.setZero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    result.chi2 = 0;
    const auto take = [&](const Eigen::Isometry3d& X_CL, const Eigen::Vector2d& measured, const Eigen::Matrix2d& W) {
      Eigen::Vector2d ray;
      Eigen::Matrix<double, 2, 3> J;
      project(X_CL, p_L, ray, J);
      const Eigen::Vector2d r = measured - ray;
      information += J.transpose() * W * J;
      gradient += J.transpose() * W * r;
      result.chi2 += r.dot(W * r);
    };
    take(X_LL, left.ray, left_weight);
    take(rig.X_RL, right.ray, right_weight);
    if (k == kSteps) break;
    step = information.ldlt().solve(gradient);
    p_L += step;
  }
  if (!has_converged(step, p_L)) return std::nullopt;
  if (!finish(rig, *meeting, p_L, information.inverse(), result)) return std::nullopt;
  return result;
}

std::optional<SphereTriangulation> triangulate_sphere(const StereoRig& rig, const SphereMeasurement& left,
                                                      const SphereMeasurement& right,
                                                      const std::optional<RadiusPrior>& prior) {
  const auto meeting = meeting_of(rig, left.value.head<2>(), right.value.head<2>());
  if (!meeting) return std::nullopt;
  Vector6 measured;
  measured << left.value, right.value;
  const Joint weight = weight_of(left, right);
  Eigen::Vector4d x, step;  // the centre in the left camera's frame, and the radius
  x << meeting->p_L, prior ? prior->radius_m : left.value.z() * meeting->p_L.norm();
  Eigen::Matrix4d information;
  SphereTriangulation result;
  for (int k = 0; k <= kSteps; ++k) {
    Eigen::Matrix<double, 6, 4> J;
    Vector6 expected;
    expect_sphere(rig, x, expected, J);
    const Vector6 r = measured - expected;
    const Eigen::Matrix<double, 4, 6> weighted = J.transpose() * weight;
    information = weighted * J;
    Eigen::Vector4d gradient = weighted * r;
    result.chi2 = r.dot(weight * r);
    if (prior) {
      const double of_prior = 1 / (prior->sigma_m * prior->sigma_m), apart = prior->radius_m - x[3];
      information(3, 3) += of_prior;
      gradient[3] += of_prior * apart;
      result.chi2 += of_prior * apart * apart;
    }
    if (k == kSteps) break;
    step = information.ldlt().solve(gradient);
    x += step;
  }
  if (!has_converged(step.head<3>(), x.head<3>())) return std::nullopt;
  const Eigen::Matrix4d covariance = information.inverse();
  result.degrees_of_freedom = prior ? 3 : 2;
  result.radius_m = x[3];
  result.radius_sigma_m = std::sqrt(covariance(3, 3));
  if (!covariance.allFinite() || !finish(rig, *meeting, x.head<3>(), covariance.topLeftCorner<3, 3>(), result))
    return std::nullopt;
  return result;
}

Eigen::Matrix3d sphere_covariance_at(const StereoRig& rig, const Eigen::Vector3d& p_W, double radius_m,
                                     const SphereMeasurement& left, const SphereMeasurement& right) {
  Eigen::Vector4d x;
  x << rig.X_WL.inverse() * p_W, radius_m;
  Eigen::Matrix<double, 6, 4> J;
  Vector6 expected;
  expect_sphere(rig, x, expected, J);
  const Eigen::Matrix4d covariance = (J.transpose() * weight_of(left, right) * J).inverse();
  const Eigen::Matrix3d R_WL = rig.X_WL.linear();
  return R_WL * covariance.topLeftCorner<3, 3>() * R_WL.transpose();
}

}  // namespace multireach::vision
