#pragma once

#include <array>
#include <cstdint>

#include "controller/ik/shoulder_elbow.hpp"
#include "numeric/rows.hpp"

namespace multireach::controller {

/// kRowLanes questions to ShoulderElbow::nearest at once, and what it answers.
struct PostureQueries {
  std::array<Row, 3> x_T{};      ///< targets, m, in W; finite
  std::array<Row, 4> theta{};    ///< which posture each shall be near to
  std::array<Row, 4> posture{};  ///< the answers
};

/// Fills in the postures, bit for bit those of ShoulderElbow::nearest. Returns a mask: bit a is set where question a
/// has an answer.
uint32_t nearest_postures(const ShoulderElbow& arm, PostureQueries& queries);

}  // namespace multireach::controller
