#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "imaging/image_codec.hpp"

namespace multireach {

/// One image, encoded as in the message.
struct Frame {
  int64_t utime = 0;  ///< time of capture, microseconds
  int width = 0, height = 0;
  int row_stride = 0;
  int32_t pixelformat = 0;
  std::vector<uint8_t> data{};
};

/// Converts an 8-bit BGR image to a frame: JPEG of this quality, or raw for 0.
Frame frame_of(ImageCodec& codec, const cv::Mat& bgr, int64_t utime, int jpeg_quality);

}  // namespace multireach
