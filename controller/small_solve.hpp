#pragma once

#include <array>

namespace multireach::controller {

#include "controller/small_solve.inl.hpp"

}  // namespace multireach::controller
