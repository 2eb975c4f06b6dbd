#pragma once

#include <cstdint>
#include <vector>

namespace multireach {

/// One image, encoded as in the message.
struct Frame {
  int64_t utime = 0;  ///< time of capture, microseconds
  int width = 0, height = 0;
  int row_stride = 0;
  int32_t pixelformat = 0;
  std::vector<uint8_t> data{};
};

}  // namespace multireach
