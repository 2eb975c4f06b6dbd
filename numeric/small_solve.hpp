#pragma once

#include <array>

namespace multireach {

#include "numeric/small_solve.inl.hpp"

}  // namespace multireach
