#pragma once

#include <array>

#include "controller/task/orientation_error.hpp"
#include "controller/task/task_target.hpp"

namespace multireach::controller {

// The error and Jacobian rows of a task: M = 3 (position), 5 (pointing) or 6 (pose). Rows 3 and up are orientation
// errors in metres: rad times `length`, the distance that weighs as much as 1 rad.

/// Calls `function` with the number of rows of a task as its template argument.
template <class Function>
auto with_rows(TaskKind task, Function&& function) {
  switch (task) {
    case TaskKind::kPointing:
      return function.template operator()<5>();
    case TaskKind::kPose:
      return function.template operator()<6>();
    default:
      return function.template operator()<3>();
  }
}

/// The desired axes of the tool frame (columns, in W): all three for a pose; for pointing only the third is set.
/// `tool`: rotation of the tool frame in the tip frame T.
inline Columns3 goal_axes(const TaskTarget& target, const Eigen::Matrix3d& tool) {
  if (target.task == TaskKind::kPose) return columns_of(target.orientation * tool);
  return {Vector3{}, Vector3{}, {target.direction[0], target.direction[1], target.direction[2]}};
}

/// The orientation error from the axes `from` to the axes `to`, m. For a pose: the rotation vector in W. For pointing:
/// its components along the first two axes of `from`.
template <int M>
[[gnu::always_inline]] inline std::array<double, M - 3> orientation_error(const Columns3& from, const Columns3& to,
                                                                          double length) {
  std::array<double, M - 3> error;
  if constexpr (M == 6) {
    const Vector3 w = rotation_vector(from, to);
    for (size_t k = 0; k < 3; ++k) error[k] = length * w[k];
  } else if constexpr (M == 5) {
    const Vector3 w = pointing_vector(from[2], to[2], from[0]);
    for (size_t r = 0; r < 2; ++r) {
      error[r] = length * (from[r][0] * w[0] + from[r][1] * w[1] + from[r][2] * w[2]);
    }
  }
  return error;
}

/// The element for joint i in row 3 + `row` of the task's Jacobian. `hand` is a FastHand with rotation.
template <int M, class Hand>
auto orientation_row(const Hand& hand, int row, int i, double length) {
  if constexpr (M == 6) {
    return hand.jacobian[3 + row][i] * length;
  } else {
    const auto& axis = hand.rotation[row];
    return (axis[0] * hand.jacobian[3][i] + axis[1] * hand.jacobian[4][i] + axis[2] * hand.jacobian[5][i]) * length;
  }
}

}  // namespace multireach::controller
