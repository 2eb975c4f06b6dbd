#include "controller/ik/closed_form.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>

#include "numeric/trigonometry.hpp"

namespace multireach::controller {
namespace {

#include "controller/ik/closed_form.inl.hpp"

constexpr double kConcurrent = 1e-7;  // m: largest distance of a shoulder axis from the common point

std::array<double, 3> numbers_of(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

struct Line {
  Eigen::Vector3d point, direction;
};

/// The point nearest to both lines (least squares) and its larger distance from them; nullopt for parallel lines.
std::optional<std::pair<Eigen::Vector3d, double>> meeting_point(const Line& a, const Line& b) {
  const auto across = [](const Line& line) -> Eigen::Matrix3d {
    return Eigen::Matrix3d::Identity() - line.direction * line.direction.transpose();
  };
  if (a.direction.cross(b.direction).norm() < 1e-6) return std::nullopt;
  const Eigen::Matrix3d A = across(a), B = across(b);
  const Eigen::Vector3d p = (A + B).inverse() * (A * a.point + B * b.point);
  return std::pair(p, std::max((A * (p - a.point)).norm(), (B * (p - b.point)).norm()));
}

}  // namespace

std::optional<ClosedFormIk> ClosedFormIk::from(const Chain& chain, int samples) {
  if (chain.size() != 4 || samples < 2) return std::nullopt;
  std::array<Line, 4> axes;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 4; ++i) {
    if (chain.joint(i).type == Joint::Type::kPrismatic) return std::nullopt;
    X = X * chain.fixed(i);
    axes[i] = {X.translation(), X.linear() * chain.joint(i).axis};
  }
  const auto meeting = meeting_point(axes[0], axes[1]);
  if (!meeting || meeting->second > kConcurrent) return std::nullopt;
  const Eigen::Vector3d shoulder = meeting->first;
  if ((shoulder - axes[2].point).cross(axes[2].direction).norm() > kConcurrent) return std::nullopt;
  const Eigen::Vector3d elbow = axes[3].point - shoulder;
  const Eigen::Vector3d forearm = (X * chain.fixed(4)).translation() - axes[3].point;
  const Eigen::Vector3d& e = axes[3].direction;
  const Eigen::Vector3d u = elbow - e * e.dot(elbow), f = forearm - e * e.dot(forearm);
  const double A = u.dot(f), B = u.dot(e.cross(f));
  const Eigen::Vector3d across = axes[0].direction.cross(axes[1].direction);
  ClosedFormArm arm;
  arm.shoulder = numbers_of(shoulder);
  arm.elbow = numbers_of(elbow);
  arm.forearm = numbers_of(forearm);
  for (int i = 0; i < 4; ++i) {
    arm.axis[i] = numbers_of(axes[i].direction);
    arm.lower[i] = chain.lower()[i];
    arm.upper[i] = chain.upper()[i];
  }
  arm.elbow2 = elbow.squaredNorm();
  arm.forearm2 = forearm.squaredNorm();
  arm.radius = std::sqrt(A * A + B * B);
  arm.middle = arc_tangent(B, A);
  arm.along = e.dot(elbow) * e.dot(forearm);
  arm.cosine12 = axes[0].direction.dot(axes[1].direction);
  arm.inverse_sine12_2 = 1 / across.squaredNorm();
  arm.across12 = numbers_of(across);
  arm.samples = samples;
  arm.third_from = chain.sample_lower(2);
  arm.third_to = chain.sample_upper(2);
  arm.third_step = (arm.third_to - arm.third_from) / (samples - 1);
  for (int k = 0; k < samples; ++k) {
    const Eigen::Matrix3d R = rotation_about(axes[2].direction, arm.third(k));
    arm.turned.push_back({numbers_of(R.row(0)), numbers_of(R.row(1)), numbers_of(R.row(2))});
  }
  return ClosedFormIk(std::move(arm));
}

std::optional<JointVector> ClosedFormIk::nearest(const Eigen::Vector3d& x_T, const JointVector& theta) const {
  ClosedFormSearch<double> search(arm_, numbers_of(x_T), {theta[0], theta[1], theta[2], theta[3]});
  std::array<double, 4> posture;
  if (!search.search(posture)) return std::nullopt;
  return Eigen::Map<const Eigen::Vector4d>(posture.data());
}

}  // namespace multireach::controller
