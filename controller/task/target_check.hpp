#pragma once

#include <optional>

#include "controller/task/task_target.hpp"

namespace multireach::controller {

/// The rotation nearest to R, where R differs from it by rounding or by numbers written with three digits: no element
/// of R R^T - I above 1e-3. nullopt otherwise. A rotation to 1e-9 is returned as it is.
std::optional<Eigen::Matrix3d> nearest_rotation(const Eigen::Matrix3d& R);

/// The target with a unit direction and an orthonormal orientation, where its task uses them and they are so to 1e-3;
/// nullopt for a target that target_fault() refuses.
std::optional<TaskTarget> checked_target(const TaskTarget& target);

/// Why a target is refused, as a sentence; nullptr for a valid target.
const char* target_fault(const TaskTarget& target);

}  // namespace multireach::controller
