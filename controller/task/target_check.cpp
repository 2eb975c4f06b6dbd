#include "controller/task/target_check.hpp"

#include <Eigen/LU>
#include <cmath>

namespace multireach::controller {
namespace {

constexpr double kExact = 1e-9;    // of R R^T - I, and of the length of a direction: left as it is
constexpr double kRounded = 1e-3;  // corrected; beyond, another mistake is likelier than rounding

double distance_from_rotations(const Eigen::Matrix3d& R) {
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

}  // namespace

std::optional<Eigen::Matrix3d> nearest_rotation(const Eigen::Matrix3d& R) {
  if (!R.allFinite() || !(distance_from_rotations(R) <= kRounded) || R.determinant() <= 0) return std::nullopt;
  if (distance_from_rotations(R) < kExact) return R;
  Eigen::Matrix3d nearest = R;
  // Newton's iteration for the polar decomposition squares the error each time: 1e-3, 1e-6, 1e-12, rounding.
  for (int k = 0; k < 4; ++k) {
    nearest = 0.5 * nearest * (3 * Eigen::Matrix3d::Identity() - nearest.transpose() * nearest);
  }
  return nearest;
}

const char* target_fault(const TaskTarget& target) {
  if (!target.position.allFinite()) return "the target's position is not finite";
  if (!target.velocity.allFinite()) return "the target's velocity is not finite";
  const bool unit = target.direction.allFinite() && std::abs(target.direction.norm() - 1) <= kRounded;
  if (target.task == TaskKind::kPointing && !unit)
    return "the target's direction is not a unit vector; expected a length of 1, within 0.001";
  if (target.task == TaskKind::kPose && !nearest_rotation(target.orientation))
    return "the target's orientation is not a rotation matrix; expected orthonormal columns, within 0.001, and "
           "determinant 1";
  return nullptr;
}

std::optional<TaskTarget> checked_target(const TaskTarget& target) {
  if (target_fault(target)) return std::nullopt;
  TaskTarget checked = target;
  if (target.task == TaskKind::kPose) checked.orientation = *nearest_rotation(target.orientation);
  if (target.task == TaskKind::kPointing && std::abs(target.direction.norm() - 1) >= kExact)
    checked.direction.normalize();
  return checked;
}

}  // namespace multireach::controller
