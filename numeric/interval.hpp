#pragma once

namespace multireach {

#include "numeric/interval.inl.hpp"

}  // namespace multireach
