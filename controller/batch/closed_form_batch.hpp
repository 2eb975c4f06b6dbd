#pragma once

#include <array>
#include <cstdint>

#include "controller/ik/closed_form.hpp"
#include "numeric/rows.hpp"

namespace multireach::controller {

/// kRowLanes queries of ClosedFormIk::nearest, and their solutions.
struct IkQueries {
  std::array<Row, 3> x_T{};      ///< targets, m, in W; finite
  std::array<Row, 4> theta{};    ///< the configurations to which the solutions should be near
  std::array<Row, 4> posture{};  ///< the IK solutions
};

/// Writes the IK solutions, bit-identical to ClosedFormIk::nearest. Returns a mask: bit a is set when query a has a
/// solution.
[[nodiscard]] uint32_t closed_form_batch(const ClosedFormIk& arm, IkQueries& queries);

}  // namespace multireach::controller
