#pragma once

#include <array>

#include "kinematics/joint_vector.hpp"
#include "numeric/lanes.hpp"
#include "numeric/small_solve.hpp"

namespace multireach::controller {

#include "controller/qp/box_qp.inl.hpp"

}  // namespace multireach::controller
