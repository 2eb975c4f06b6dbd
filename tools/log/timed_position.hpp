#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace multireach {

struct TimedPosition {
  int64_t utime;        ///< microseconds
  Eigen::Vector3d p_W;  ///< m, in W
};

}  // namespace multireach
