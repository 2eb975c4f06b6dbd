#pragma once

#include <limits>

#include "controller/qp/barrier_rate.hpp"
#include "numeric/lanes.hpp"

namespace multireach::controller {

#include "controller/qp/velocity_bounds.inl.hpp"

}  // namespace multireach::controller
