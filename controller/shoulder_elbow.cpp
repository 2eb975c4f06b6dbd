#include "controller/shoulder_elbow.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include "kinematics/trigonometry.hpp"

namespace multireach::controller {
namespace {

constexpr double kConcurrent = 1e-7;  // m: how far apart the three shoulder axes may pass
constexpr double kAtLimit = 1e-9;     // rad: an angle this little beyond a limit is taken as the limit
constexpr double kAtBoundary =
    1e-12;  // relative: a target this little out of reach is taken as reached by a stretched arm
constexpr double kTurn = 2 * std::numbers::pi;

struct Line {
  Eigen::Vector3d point, direction;
};

/// The point nearest to both lines (least squares), and how far the lines are from it; nothing for parallel lines.
std::optional<std::pair<Eigen::Vector3d, double>> meeting_point(const Line& a, const Line& b) {
  const auto across = [](const Line& line) -> Eigen::Matrix3d {
    return Eigen::Matrix3d::Identity() - line.direction * line.direction.transpose();
  };
  if (a.direction.cross(b.direction).norm() < 1e-6) return std::nullopt;
  const Eigen::Matrix3d A = across(a), B = across(b);
  const Eigen::Vector3d p = (A + B).inverse() * (A * a.point + B * b.point);
  return std::pair(p, std::max((A * (p - a.point)).norm(), (B * (p - b.point)).norm()));
}

/// The angle by which `from` is turned about `axis` to come nearest to `to`; `otherwise` where the axis leaves it open.
double angle_about(const Eigen::Vector3d& axis, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                   double otherwise) {
  const Eigen::Vector3d a = from - axis * axis.dot(from), b = to - axis * axis.dot(to);
  const double scale = from.norm();
  if (a.norm() < 1e-9 * scale || b.norm() < 1e-9 * scale) return otherwise;
  return arc_tangent(axis.dot(a.cross(b)), a.dot(b));
}

/// The representative of `angle`, modulo whole turns, that is inside the joint's limits and nearest to `near`.
std::optional<double> inside_limits(const Chain& chain, int i, double angle, double near) {
  const double turns = std::round((near - angle) / kTurn);
  std::optional<double> best;
  for (const int k : {-1, 0, 1}) {
    double candidate = angle + (turns + k) * kTurn;
    if (candidate < chain.lower()[i] - kAtLimit || candidate > chain.upper()[i] + kAtLimit) continue;
    candidate = std::clamp(candidate, chain.lower()[i], chain.upper()[i]);
    if (!best || std::abs(candidate - near) < std::abs(*best - near)) best = candidate;
  }
  return best;
}

}  // namespace

std::optional<ShoulderElbow> ShoulderElbow::from(const Chain& chain) {
  if (chain.size() != 4) return std::nullopt;
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
  ShoulderElbow arm;
  arm.shoulder_ = shoulder;
  for (int i = 0; i < 4; ++i) arm.axis_[i] = axes[i].direction;
  arm.elbow_ = axes[3].point - shoulder;
  arm.forearm_ = (X * chain.fixed(4)).translation() - axes[3].point;
  return arm;
}

std::optional<JointVector> ShoulderElbow::posture(const Chain& chain, const Eigen::Vector3d& v,
                                                  const JointVector& theta, double third, double fourth,
                                                  int branch) const {
  const Eigen::Vector3d h = elbow_ + rotation_about(axis_[3], fourth) * forearm_;
  const Eigen::Vector3d w = rotation_about(axis_[2], third) * h;
  // z = R2 w = R1^-1 v lies on two cones and a sphere.
  const Eigen::Vector3d across = axis_[0].cross(axis_[1]);
  const double c = axis_[0].dot(axis_[1]), sine2 = across.squaredNorm();
  const double on1 = axis_[0].dot(v), on2 = axis_[1].dot(w);
  const double a = (on1 - c * on2) / sine2, b = (on2 - c * on1) / sine2;
  double height2 = (v.squaredNorm() - a * a - b * b - 2 * a * b * c) / sine2;
  if (height2 < -kAtBoundary * v.squaredNorm()) return std::nullopt;
  height2 = std::max(height2, 0.0);
  const Eigen::Vector3d z = a * axis_[0] + b * axis_[1] + (branch ? -1 : 1) * std::sqrt(height2) * across;
  const auto second = inside_limits(chain, 1, angle_about(axis_[1], w, z, theta[1]), theta[1]);
  if (!second) return std::nullopt;
  const auto first = inside_limits(chain, 0, angle_about(axis_[0], z, v, theta[0]), theta[0]);
  if (!first) return std::nullopt;
  JointVector posture(4);
  posture << *first, *second, third, fourth;
  return posture;
}

namespace {
constexpr int kMostCuts = 80;  // each leaves 0.62 of the bracket
}

std::optional<JointVector> ShoulderElbow::nearest(const Chain& chain, const Eigen::Vector3d& x_T,
                                                  const JointVector& theta, int samples) const {
  const Eigen::Vector3d v = x_T - shoulder_;
  // |elbow + Rot(axis, angle) forearm|^2 = |v|^2, as A cos(angle) + B sin(angle) = C.
  const Eigen::Vector3d& e = axis_[3];
  const Eigen::Vector3d u = elbow_ - e * e.dot(elbow_), f = forearm_ - e * e.dot(forearm_);
  const double A = u.dot(f), B = u.dot(e.cross(f));
  const double C =
      0.5 * (v.squaredNorm() - elbow_.squaredNorm() - forearm_.squaredNorm()) - e.dot(elbow_) * e.dot(forearm_);
  const double radius = std::sqrt(A * A + B * B);
  if (!(std::abs(C) <= radius + kAtBoundary * v.squaredNorm())) return std::nullopt;
  const double middle = arc_tangent(B, A), half = arc_cosine(std::clamp(C / radius, -1.0, 1.0));

  const double lower = chain.sample_lower(2), upper = chain.sample_upper(2), step = (upper - lower) / (samples - 1);
  std::optional<JointVector> best;
  double best_distance = std::numeric_limits<double>::infinity(), best_third = 0;
  int best_branch = 0;
  const auto consider = [&](double third, double fourth, int branch) {
    const auto candidate = posture(chain, v, theta, third, fourth, branch);
    const double distance = candidate ? (*candidate - theta).squaredNorm() : std::numeric_limits<double>::infinity();
    if (distance < best_distance) {
      best = candidate;
      best_distance = distance;
      best_third = third;
      best_branch = branch;
    }
    return distance;
  };
  for (const double sign : {-1.0, 1.0}) {
    const auto fourth = inside_limits(chain, 3, middle + sign * half, theta[3]);
    if (!fourth) continue;
    for (int branch = 0; branch < 2; ++branch) {
      for (int k = 0; k < samples; ++k) consider(std::min(lower + k * step, upper), *fourth, branch);
      consider(std::clamp(theta[2], lower, upper), *fourth, branch);
    }
  }
  if (!best) return std::nullopt;
  // Golden-section search between the neighbours of the best sample, on its curve.
  const double fourth = (*best)[3], ratio = 1 / std::numbers::phi;
  const int branch = best_branch;
  double from = std::max(best_third - step, lower), to = std::min(best_third + step, upper);
  double left = to - ratio * (to - from), right = from + ratio * (to - from);
  double at_left = consider(left, fourth, branch), at_right = consider(right, fourth, branch);
  for (int k = 0; k < kMostCuts && to - from > 1e-9; ++k) {
    if (at_left < at_right) {
      to = right;
      right = left;
      at_right = at_left;
      left = to - ratio * (to - from);
      at_left = consider(left, fourth, branch);
    } else {
      from = left;
      left = right;
      at_left = at_right;
      right = from + ratio * (to - from);
      at_right = consider(right, fourth, branch);
    }
  }
  return best;
}

}  // namespace multireach::controller
