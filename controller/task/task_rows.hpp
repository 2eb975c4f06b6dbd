#pragma once

#include <array>

#include "controller/task/hand_error.hpp"
#include "controller/task/hand_target.hpp"

namespace multireach::controller {

// The rows of a task of M = 3 (position), 5 (pointing) or 6 (pose) rows. Rows 3 and up are about the orientation, in
// metres: rotations times `length`, the distance that counts as much as 1 rad.

/// Calls `function` with the number of rows of a task as its template argument.
template <class Function>
auto with_rows(Aim aim, Function&& function) {
  switch (aim) {
    case Aim::kPointing:
      return function.template operator()<5>();
    case Aim::kPose:
      return function.template operator()<6>();
    default:
      return function.template operator()<3>();
  }
}

/// The axes (columns, in W) that the tool's frame shall have: all three for a pose, the third alone for pointing.
/// `tool` turns the hand's axes into the tool's.
inline Columns3 goal_axes(const HandTarget& target, const Eigen::Matrix3d& tool) {
  if (target.aim == Aim::kPose) return columns_of(target.orientation * tool);
  return {Vector3{}, Vector3{}, {target.direction[0], target.direction[1], target.direction[2]}};
}

/// The orientation part of the error that leads from the axes `from` to the axes `to`, m: for a pose its rotation
/// vector in W; for pointing its parts along the first two axes of `from`.
template <int M>
std::array<double, M - 3> orientation_error(const Columns3& from, const Columns3& to, double length) {
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

/// Row 3 + `row` of the task's Jacobian, its element for joint i: `hand` is a FastHand with rotation.
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
